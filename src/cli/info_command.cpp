// SPDX-License-Identifier: Apache-2.0
#include "info_command.h"

#include "console.h"
#include "guarded_loading.h"
#include "info_text.h"
#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/scene/frame_path.h>
#include <scrim/volume/foreign_format.h>
#include <scrim/guard/guarded_load.h>
#include <scrim/guard/load_fields.h>
#include <scrim/shot/scan_info.h>
#include <scrim/volume/vdb_info_text.h>

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

namespace scrim::cli {
namespace {

/// An argument: one file, or a sequence with the wanted frames.
struct Asked {
    std::string name;
    std::vector<int> frames;  ///< empty: one file
    std::vector<std::string> files;
};

Asked asked(const std::string& argument, const std::vector<int>& frames) {
    std::error_code ignored;
    if (std::filesystem::exists(argument, ignored) || !hasFrame(argument)) return {argument, {}, {argument}};
    const FramePath path{"", argument};
    Asked out{argument, {}, {}};
    for (const int frame : frames.empty() ? existingFrames(path) : frames) {
        out.frames.push_back(frame);
        out.files.push_back(path.at(frame));
    }
    if (out.files.empty())
        throw Error(ErrorKind::input, fmt::format("{}: the sequence has no files", shortened(argument)));
    return out;
}

class Info {
  public:
    explicit Info(const InfoOptions& options) : m_options(options), m_loading(guardedLoading(0, options.verbose)) {}

    void run() {
        std::size_t files = 0;
        for (const std::string& argument : m_options.files) {
            const Asked what = asked(argument, m_options.frames);
            files += what.files.size();
            for (const std::string& file : what.files)
                if (const ForeignFormat* const format = foreignFormat(file))
                    throw Error(ErrorKind::input, fmt::format("{}: {}", shortened(file), textOf(*format)));
            if (what.frames.size() > 1 && !m_options.json && !isScanFile(what.name))
                addSequence(what);
            else
                for (const std::string& file : what.files) addFile(file);
        }
        if (m_options.json) m_text = (files > 1 ? "[" + m_text + "]" : m_text) + "\n";
        printOut(m_text);
    }

  private:
    void add(const std::string& text) {
        if (!m_text.empty()) m_text += m_options.json ? ",\n" : "\n";
        m_text += text;
    }
    void addFile(const std::string& file) {
        if (isScanFile(file)) {
            const ScanInfo info = loadScanInfo(file, m_loading, throwIfInterrupted);
            return add(m_options.json ? toJson(info) : infoText(info));
        }
        const VdbFileInfo info = infoOf(file);
        add(m_options.json ? toJson(info) : infoText(info));
    }
    VdbFileInfo infoOf(const std::string& file) const {
        if (m_options.ax.empty()) return loadInfo(file, m_loading, throwIfInterrupted);
        GridEdit edit;
        edit.programs = {{m_options.ax, "--ax", ""}};
        return guardedInfo(file, m_loading, throwIfInterrupted, &edit);
    }
    void addSequence(const Asked& what) {
        std::vector<VdbFileInfo> infos;
        for (const std::string& file : what.files) infos.push_back(infoOf(file));
        add(sequenceText(what.name, what.frames, infos));
    }

    const InfoOptions& m_options;
    LoadOptions m_loading;
    std::string m_text;
};

}  // namespace

void infoCommand(const InfoOptions& options) {
    Info(options).run();
}

}  // namespace scrim::cli
