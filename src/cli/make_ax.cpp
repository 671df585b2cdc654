// SPDX-License-Identifier: Apache-2.0
#include "make_ax.h"

#include "guarded_loading.h"
#include "interrupt.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/guard/guarded_load.h>

#include <fmt/format.h>

#include <charconv>

namespace scrim::cli {
namespace {

/// One number, or three with commas between them.
std::vector<double> numbersOf(const std::string& name, const std::string& text) {
    std::vector<double> numbers;
    const char *at = text.data(), *const end = at + text.size();
    while (at < end) {
        double value = 0;
        const auto [stop, error] = std::from_chars(at, end, value);
        if (error != std::errc() || stop == at) break;
        numbers.push_back(value);
        at = stop;
        while (at < end && (*at == ',' || *at == ' ')) ++at;
    }
    if (at != end || (numbers.size() != 1 && numbers.size() != 3))
        throw Error(ErrorKind::usage, fmt::format("'{}={}': expected a number, or three with commas between them", name,
                                                  shortened(text, 80)));
    return numbers;
}

}  // namespace

void makeAx(const std::vector<std::pair<std::string, std::string>>& parameters, const std::string& output, bool verbose,
            Console& console) {
    GridEdit edit;
    std::string file;
    for (const auto& [name, value] : parameters) {
        if (name == "file")
            file = value;
        else if (name == "code")
            edit.programs = {{value, "code", ""}};
        else if (name == "ax_file")
            edit.programs = {{axFileText(value), value, value}};
        else if (name == "resample")
            edit.resample = numbersOf(name, value).front();
        else
            edit.variables.push_back({name, numbersOf(name, value)});
        if (!edit.variables.empty() && !edit.variables.back().isFinite())
            throw Error(ErrorKind::usage, fmt::format("'{}={}': expected finite numbers that fit into floats", name,
                                                      shortened(value, 80)));
    }
    edit.where = "make ax";
    if (file.empty() || (edit.programs.empty() && edit.resample == 1))
        throw Error(ErrorKind::usage, "make ax: expected file=IN.vdb, and code=CODE or ax_file=FILE or resample=2");
    if (!(edit.resample >= 0.125 && edit.resample <= 16))
        throw Error(ErrorKind::usage, fmt::format("'resample={}': expected a number from 0.125 to 16", edit.resample));
    const std::string bytes = guardedFile(file, edit, guardedLoading(0, verbose), console.sink(), throwIfInterrupted);
    writeWholeFile(output, bytes);
}

}  // namespace scrim::cli
