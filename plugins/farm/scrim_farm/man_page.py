# SPDX-License-Identifier: Apache-2.0
"""The man page of scrim-submit, from the table of its options."""
import argparse


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def term(action):
    names = ", ".join(f"\\fB{escaped(name)}\\fR" for name in action.option_strings)
    value = action.metavar or "|".join(action.choices or ()) or action.dest.upper()
    if action.nargs == 0:
        return names
    return f"{names} \\fI{escaped(value)}\\fR".strip()


def man_page(parser):
    """`parser` as roff: scrim-submit(1)."""
    lines = ['.TH SCRIM\\-SUBMIT 1 "" "" "Scrim"', ".SH NAME",
             "scrim\\-submit \\- send a shot of scrim to a render farm",
             ".SH SYNOPSIS", "\\fBscrim\\-submit\\fR [\\fIoptions\\fR] \\fISCENE\\fR",
             ".SH DESCRIPTION", escaped(parser.description), ".SH OPTIONS"]
    for action in parser._actions:
        if action.help != argparse.SUPPRESS:
            lines += [".TP", term(action), escaped(action.help)]
    lines += [".SH EXAMPLES", ".nf"]
    lines += [escaped(line.strip()) for line in parser.epilog.splitlines()[1:]]
    lines += [".fi", ".SH SEE ALSO", ".BR scrim (1),", ".BR scrim\\-render (1),", ".BR scrim\\-merge (1)"]
    return "\n".join(lines) + "\n"
