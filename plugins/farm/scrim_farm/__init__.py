# SPDX-License-Identifier: Apache-2.0
"""Shots on render farms. A job is a folder: job.json says what is rendered, state/ how each task went, log/ what it
said. All that runs on the farm reads that folder, so any machine that sees it can tell what is missing."""
