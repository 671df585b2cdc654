# SPDX-License-Identifier: Apache-2.0
"""Shots on render farms. A job is a folder with job.json, which holds the shot, state/, how each task went, and
log/, what each task wrote. Everything that runs on the farm reads this folder, so any machine that sees it can tell
what is missing."""
