// SPDX-License-Identifier: Apache-2.0
#include "make_command.h"

#include "console.h"
#include "file_claims.h"
#include "guarded_loading.h"
#include "interrupt.h"
#include "make_ax.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/shot/shot_text.h>
#include <scrim/guard/load_fields.h>
#include <scrim/volume/source.h>
#include <scrim/volume/vdb_write.h>

#include <fmt/format.h>

namespace scrim::cli {
namespace {

std::string allowedText(const ParameterDescription& p) {
    if (!p.choices.empty()) return choices(p.choices);
    if (p.limited()) return fmt::format("{} from {} to {}", typeName(p.type), p.minimum, p.maximum);
    return typeName(p.type);
}

std::string describedText(const SourceDescription& source) {
    std::string text = fmt::format("{}: {}\n  ({})\n", source.name, source.description, source.path);
    for (const ParameterDescription& p : source.parameters)
        text += fmt::format("  {:<24} {}; {}\n", p.name + "=" + p.defaultText, p.help, allowedText(p));
    return text;
}

std::vector<std::pair<std::string, std::string>> split(const std::vector<std::string>& assignments) {
    std::vector<std::pair<std::string, std::string>> out;
    for (const std::string& text : assignments) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0)
            throw Error(ErrorKind::usage, fmt::format("'{}': expected key=value", shortened(text, 80)));
        out.emplace_back(text.substr(0, equals), text.substr(equals + 1));
    }
    return out;
}

/// Checks the output's name, and that it is not the file that the source reads.
void checkOutput(const std::string& output, const std::vector<std::pair<std::string, std::string>>& parameters) {
    if (lowerExtension(output) != ".vdb")
        throw Error(ErrorKind::usage, fmt::format("the output '{}' does not end in '.vdb'", shortened(output)));
    FileClaims claims;
    claims.reads(fileIn(parameters), "the source's 'file'");
    claims.writesAlone(output, "--output");
    const AtomicFile probe(output);
    for (const std::string& folder : claims.folders()) removeAbandonedFiles(folder);
}

void listAll(Console& console) {
    const std::vector<SourceDescription> sources = listSources(console.sink());
    for (const SourceDescription& source : sources) printOut(describedText(source));
    if (sources.empty())
        throw Error(ErrorKind::input, fmt::format("there are no volume sources in {}", choices(sourceFolders())));
}

}  // namespace

void makeCommand(const MakeOptions& options) {
    Console console(options.verbose, options.quiet);
    if (options.list) return listAll(console);
    if (options.source.empty())
        throw Error(ErrorKind::usage, "make: expected the name of a volume source; scrim make --list shows them");
    if (options.helpSource) return printOut(describedText(describeSource(options.source)));
    const auto parameters = split(options.parameters);
    if (options.output.empty()) throw Error(ErrorKind::usage, "make: expected -o OUT.vdb, the file to write");
    checkOutput(options.output, parameters);
    if (options.source == "ax") return makeAx(parameters, options.output, options.verbose, console);

    std::vector<SparseField> fields;
    TaskArena(options.threads).run([&] {
        fields = sourceFields(options.source, parameters, guardedLoading(0, options.verbose), console.sink(),
                              throwIfInterrupted);
    });
    throwIfInterrupted();
    writeVdb(options.output, fields);
    for (const SparseField& field : fields)
        console.line(
            fmt::format("{}: grid '{}' with {} active voxels", options.output, field.name, field.activeVoxels));
}

}  // namespace scrim::cli
