// SPDX-License-Identifier: Apache-2.0
// Stands for the headers that all tests include, precompiled: see tests/CMakeLists.txt.
