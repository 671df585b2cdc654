// SPDX-License-Identifier: Apache-2.0
// The Python that runs what the program leaves to Python code: OpenUSD stages and the viewer. It is started here alone:
// by itself Python would look for modules in the current folder first, and run what anybody left there.
#pragma once

#include <string>
#include <vector>

namespace scrim::cli {

/// The words of a command line that runs `code`, before which `sys` is imported, in the Python that $SCRIM_PYTHON
/// names, or in python3 beside this program, or in that of PATH. Python finds modules where it is installed and in
/// PYTHONPATH, but not in the current folder, unless PYTHONPATH names that: empty entries of it are removed from this
/// process's environment, which the child has to inherit.
std::vector<std::string> pythonCommand(const std::string& code);

}  // namespace scrim::cli
