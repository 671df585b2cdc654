// SPDX-License-Identifier: Apache-2.0
#include "usd_scenes.h"

#include "interrupt.h"
#include "python_program.h"
#include "text_file.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/shot/shot_text.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim::cli {
namespace {

constexpr const char* kHowToInstall =
    "stages are read by Scrim's Python package, with OpenUSD (pip install '.[usd]' in the folder of Scrim's sources); "
    "$SCRIM_PYTHON names the Python that has both";

/// Starts the reader, or says in one line why this Python cannot.
constexpr const char* kStart = R"(try:
    from scrim.usd.__main__ import main
except ImportError as missing:
    print("error", "input", f"{sys.executable}: {missing}; {sys.argv[1]}", sep="\t")
    sys.exit(1)
del sys.argv[1]
sys.exit(main()))";

/// A file of the folder that lists the frames: as an argument, a list of some 20,000 would be longer than the system
/// allows. "": there are none.
std::string framesFile(const std::string& folder, const std::vector<int>& frames) {
    if (frames.empty()) return "";
    const std::string path = folder + "/frames";
    writeWholeFile(path, fmt::format("{}", fmt::join(frames, ",")));
    return path;
}

std::vector<std::string> argumentsFor(const std::string& path, const std::string& folder, const SceneOptions& options) {
    std::vector<std::string> words = pythonCommand(kStart);
    words.emplace_back(kHowToInstall);
    const auto add = [&words](const char* name, const std::string& value) {
        // Option and value form one word, so that no value is taken for an option.
        if (!value.empty()) words.push_back(fmt::format("--{}={}", name, value));
    };
    add("frames", framesFile(folder, options.frames));
    if (options.resolution) add("res", fmt::format("{}x{}", options.resolution->x, options.resolution->y));
    add("camera", options.usd.camera);
    add("settings", options.usd.settings);
    add("purpose", options.usd.purpose);
    add("sidecar", options.usd.sidecar);
    add("distant", options.usd.distant);
    add("meshes", options.usd.meshes);
    words.insert(words.end(), {"--", path, folder});
    return words;
}

/// A pipe: the end to read from, and the one to write to.
std::pair<Descriptor, Descriptor> makePipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        throw Error(ErrorKind::render, std::string("cannot make a pipe: ") + std::strerror(errno));
    return {Descriptor(ends[0]), Descriptor(ends[1])};
}

// Removes a folder once its standard input is closed, though Ctrl-C reaches it, too. Whoever writes there meanwhile may
// make it try again.
constexpr const char* kKeep = R"(trap '' HUP INT TERM
read nothing
for try in 1 2 3 4 5; do rm -rf -- "$1" && exit; sleep 1; done)";

/// Starts a program whose standard output is `output`; its standard error is ours.
ChildProcess startPython(const std::vector<std::string>& words, const Descriptor& output) {
    try {
        return ChildProcess({words, "", {{0, ProgramStart::kNothing}, {1, output.fd()}}}, SIGTERM);
    } catch (const std::system_error& error) {
        throw Error(ErrorKind::input, fmt::format("cannot start '{}': {}; {}", words[0],
                                                  std::strerror(error.code().value()), kHowToInstall));
    }
}

/// What comes out of a pipe until it is closed.
std::string readAll(const Descriptor& pipe) {
    std::string text;
    char part[4096];
    for (;;) {
        throwIfInterrupted();
        const ssize_t count = ::read(pipe.fd(), part, sizeof part);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return text;
        text.append(part, static_cast<std::size_t>(count));
    }
}

/// What a program writes on standard output, and its exit status.
std::pair<std::string, int> outputOf(const std::vector<std::string>& words) {
    auto [ours, theirs] = makePipe();
    ChildProcess program = startPython(words, theirs);
    theirs = Descriptor();  // else the pipe stays open when the program ends
    const Descriptor pipe =
        std::move(ours);  // below the program, so that it is closed before the program is waited for
    std::string text = readAll(pipe);
    const int status = program.wait().status;
    return {std::move(text), WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status)};
}

std::vector<std::string> fieldsOf(const std::string& line) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
        if (c == '\t')
            fields.emplace_back();
        else
            fields.back() += c;
    }
    fields.resize(std::max<std::size_t>(fields.size(), 4));
    return fields;
}

void addScene(UsdScenes& out, const std::vector<std::string>& fields) {
    UsdScene scene{{std::stoi(fields[1])}, textOf(out.folder->path() + "/" + fields[2]), {}};
    if (!fields[3].empty()) scene.crop = parseCrop(fields[3]);
    if (!out.scenes.empty() && out.scenes.back().toml == scene.toml && out.scenes.back().crop == scene.crop)
        out.scenes.back().frames.push_back(scene.frames.front());
    else
        out.scenes.push_back(std::move(scene));
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
    const char* const named = std::getenv("TMPDIR");
    m_path = std::string(named != nullptr && *named != '\0' ? named : "/tmp") + "/scrim-usd-XXXXXX";
    auto [theirs, ours] = makePipe();
    if (::mkdtemp(m_path.data()) == nullptr)
        throw Error(ErrorKind::output,
                    fmt::format("cannot make a folder for a stage's scenes: '{}': {}", m_path, std::strerror(errno)));
    try {
        constexpr int nothing = ProgramStart::kNothing;
        m_keeper.emplace(
            ProgramStart{{"sh", "-c", kKeep, "sh", m_path}, "/bin/sh", {{0, theirs.fd()}, {1, nothing}, {2, nothing}}},
            0);
    } catch (const std::system_error& error) {
        ::rmdir(m_path.c_str());
        throw Error(ErrorKind::output, fmt::format("cannot start '/bin/sh': {}", std::strerror(error.code().value())));
    }
    m_open = std::move(ours);
}

bool isStage(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".usd" || extension == ".usda" || extension == ".usdc" || extension == ".usdz";
}

UsdScenes readStage(const std::string& path, const SceneOptions& options) {
    UsdScenes out;
    out.folder = std::make_shared<TemporaryFolder>();
    const std::vector<std::string> words = argumentsFor(path, out.folder->path(), options);
    const auto [output, status] = outputOf(words);
    std::istringstream lines(output);
    std::string first, last;
    for (std::string line; std::getline(lines, line);) {
        const std::vector<std::string> fields = fieldsOf(line);
        if (fields[0] == "stage") std::tie(first, last) = std::tie(fields[1], fields[2]);
        if (fields[0] == "scene") addScene(out, fields);
        if (fields[0] == "warning") out.warnings.push_back(fields[1]);
        if (fields[0] == "note") out.notes.push_back(fields[1]);
        if (fields[0] == "error")
            throw Error(fields[1] == "usage" ? ErrorKind::usage : ErrorKind::input,
                        fields[2].starts_with(path) ? fields[2] : path + ": " + fields[2]);
    }
    throwIfInterrupted();
    if (status != 0 || out.scenes.empty())
        throw Error(ErrorKind::input, fmt::format("{}: '{} -m scrim.usd' ended with status {}; {}", path, words[0],
                                                  status, kHowToInstall));
    if (options.frames.empty() && !options.printScene && first != last)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: give the frames with --frames (the stage has {} to {})", path, first, last));
    return out;
}

}  // namespace scrim::cli
