// SPDX-License-Identifier: Apache-2.0
// The parent's side of a guarded load; the child's is src/load.
#include <scrim/guard/guarded_load.h>

#include <scrim/base/installed.h>
#include <scrim/base/letter_case.h>
#include <scrim/base/open_file.h>
#include <scrim/base/system_error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/load_protocol.h>
#include <scrim/guard/load_request.h>
#include <scrim/guard/transfer_file.h>
#include <scrim/volume/ax_module.h>
#include <scrim/volume/loaded_source.h>
#include <scrim/guard/mesh_transfer.h>
#include <scrim/guard/picture_transfer.h>
#include <scrim/volume/vdb_bounds.h>
#include <scrim/volume/vdb_bytes.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {
namespace {

/// Bytes of memory allowed per byte of a file. OpenVDB's trees take some 35 times their smallest
/// compressed size, and the field made from them comes on top.
constexpr std::size_t kMemoryPerByte = 64;
constexpr std::uint64_t kSlowestBytesPerSecond = 1 << 20;  // the speed of a busy network drive

/// The limits on a file beyond those that depend on its size: several times what sound files need.
struct Kind {
    std::size_t leastMemory = 0;
    std::chrono::minutes patience{0};
};
constexpr Kind kVolume{std::size_t{4} << 30, std::chrono::minutes{10}};
/// Pictures have at most 50 million pixels (kMostTexturePixels), which half a million pixels per
/// second get through in time.
constexpr Kind kPicture{std::size_t{4} << 30, std::chrono::minutes{2}};
/// A source may make more than its file suggests: a mesh becomes as much fog as requested, and
/// scans are compressed. Scrim's own sources refuse larger results by themselves.
constexpr Kind kSource{std::size_t{16} << 30, std::chrono::minutes{10}};

/// Expressions make grids, and refining multiplies voxels.
constexpr Kind kEdited{std::size_t{16} << 30, std::chrono::minutes{10}};

static_assert(kMostGridFiles - 1 <= kMostDescriptors - kMore);

LoadLimits limitsFor(const Kind& kind, std::uint64_t bytes, const LoadOptions& options) {
    LoadLimits limits;
    limits.memory = options.memory > 0 ? std::max(options.memory, LoadOptions::kLeastMemory)
                                       : std::max<std::size_t>(kind.leastMemory, kMemoryPerByte * bytes);
    limits.patience = kind.patience + std::chrono::seconds(bytes / kSlowestBytesPerSecond);
    return limits;
}

/// True where these are the first bytes of a DICOM file, which says behind its preamble that it is one.
bool beginsAsDicom(std::string_view bytes) {
    constexpr std::size_t kMark = 128;
    return bytes.size() >= kMark + 4 && bytes.substr(kMark, 4) == "DICM";
}
constexpr std::size_t kDicomStart = 132;  // bytes that beginsAsDicom() needs

/// The folder whose files a source may want all of: that of a DICOM file, which is one slice of
/// many. None for other files, whatever their names: the folder would be copied in vain.
std::optional<std::string> folderOf(const std::string& path, const OpenFile& file) {
    const std::string name = lowerCase(path);
    if (!name.ends_with(".dcm") && !name.ends_with(".dicom")) return {};
    std::array<char, kDicomStart> start{};
    const ssize_t got = ::pread(file.fd(), start.data(), start.size(), 0);
    if (got < 0 || !beginsAsDicom({start.data(), static_cast<std::size_t>(got)})) return {};
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    return folder.empty() ? "." : folder.string();
}

/// True where these are the first bytes of a TIFF file, of either order and either width of offsets.
bool beginsAsTiff(std::string_view bytes) {
    return bytes.starts_with(std::string_view("II*\0", 4)) || bytes.starts_with(std::string_view("MM\0*", 4)) ||
           bytes.starts_with(std::string_view("II+\0", 4)) || bytes.starts_with(std::string_view("MM\0+", 4));
}

/// True where a file's name stands for those of several, and there is no file of that name.
bool isPattern(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::path(path).filename().string().find('*') != std::string::npos &&
           !std::filesystem::exists(path, ignored);
}

/// A file that holds the slices of a folder, as scrim_source.h describes it, because a child cannot
/// open the folder. Only their names and first bytes are looked at here.
class FolderFile {
  public:
    /// The DICOM files of a folder, or its TIFF files where it has none; of the TIFF files only those whose names
    /// may match `pattern`, unless it is "". Throws Error where a file cannot be read, or where they are too many.
    FolderFile(const std::string& folder, const std::string& pattern, const Checkpoint& checkpoint)
        : m_file(createTransfer()) {
        std::error_code error;
        std::vector<std::filesystem::path> dicom, tiff;
        for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
            if (checkpoint) checkpoint();
            if (!at->is_regular_file(error) || !mayMatch(at->path().filename().string(), pattern)) continue;
            const std::string start = startOf(at->path());
            if (beginsAsDicom(start) && pattern.empty()) dicom.push_back(at->path());
            if (beginsAsTiff(start)) tiff.push_back(at->path());
        }
        if (error && pattern.empty()) throw Error(ErrorKind::input, fmt::format("{}: {}", folder, error.message()));
        m_isDicom = !dicom.empty();
        std::vector<std::filesystem::path>& paths = m_isDicom ? dicom : tiff;
        std::sort(paths.begin(), paths.end());
        add("scrim folder\n", folder);
        for (const std::filesystem::path& path : paths) {
            if (checkpoint) checkpoint();
            addFile(path);
        }
    }
    int fd() const { return m_file.fd(); }
    std::uint64_t size() const { return m_size; }
    bool isDicom() const { return m_isDicom; }

  private:
    void add(const std::string& bytes, const std::string& path) {
        constexpr std::uint64_t kMost = std::uint64_t{16} << 30;
        if (bytes.size() > kMost - m_size)
            throw Error(ErrorKind::input, fmt::format("{}: the folder holds more than 16 GB of DICOM files", path));
        if (!writeAll(m_file.fd(), bytes.data(), bytes.size(), m_size))
            throw Error(kindOfSystemError(errno, ErrorKind::memory),
                        fmt::format("{}: cannot be copied for its reader: {}", path, systemErrorText(errno)));
        m_size += bytes.size();
    }
    void addFile(const std::filesystem::path& path) {
        const std::string name = path.filename().string();
        std::ifstream in(path, std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(in), {});
        if (name.find('\n') != std::string::npos) return;
        add(fmt::format("{} {}\n", bytes.size(), name), path.string());
        add(bytes, path.string());
    }
    static std::string startOf(const std::filesystem::path& path) {
        std::string bytes(kDicomStart, '\0');
        std::ifstream(path, std::ios::binary).read(bytes.data(), std::streamsize(bytes.size()));
        return bytes;
    }
    /// The source has the last word.
    static bool mayMatch(const std::string& name, const std::string& pattern) {
        const std::size_t first = pattern.find('*'), last = pattern.rfind('*');
        return pattern.empty() ||
               (name.starts_with(pattern.substr(0, first)) && name.ends_with(pattern.substr(last + 1)));
    }

    Descriptor m_file;
    std::uint64_t m_size = 0;
    bool m_isDicom = false;
};

/// What messages about a child call its work.
std::string workOn(const std::string& name, const GridEdit* edit) {
    if (edit == nullptr || edit->programs.empty()) return name;
    return fmt::format("{}: {} with its 'ax'", edit->programs.front().where, name);
}

LoadEdit loadEdit(const GridEdit& edit) {
    return {edit, edit.programs.empty() ? "" : besideLibrary(kAxModule)};
}

std::optional<LoadEdit> loadEdit(const GridEdit* edit) {
    return edit == nullptr ? std::nullopt : std::optional(loadEdit(*edit));
}

/// Starts a child for a task with a volume file, and with the others that its edit names. They are
/// opened here, because children cannot open files.
LoadJob begin(const std::string& path, LoadTask task, const LoadOptions& options, int transfer) {
    const LoadRequest request{path, std::move(task)};
    const LoadEdit* const first = editOf(request.task);
    const GridEdit* const edit = first == nullptr ? nullptr : &first->edit;
    const VdbFiles files = openFiles(path, edit == nullptr ? std::span<const std::string>() : edit->files);
    sendRequest(transfer, request);
    std::uint64_t bytes = 0;
    std::vector<int> descriptors;
    for (const auto& file : files) {
        bytes += file->size();
        descriptors.push_back(file->descriptor());
    }
    // Points may become more voxels than the size of their file suggests.
    const bool made = edit != nullptr || holdsPoints(*files.front());
    return LoadJob(options.loader, LoadedFiles::volumes, workOn(path, edit),
                   {transfer, descriptors.front(), -1, std::span(descriptors).subspan(1)},
                   limitsFor(made ? kEdited : kVolume, bytes, options), options.showStderr);
}

/// Runs `receive` and puts the path in front of its error about an incomplete transfer.
template <typename Receive>
auto received(const std::string& path, const Receive& receive) {
    try {
        return receive();
    } catch (const GridError&) {
        throw;
    } catch (const BesideError&) {
        throw;
    } catch (const Error& error) {
        const std::string text = error.what();
        if (text.starts_with("what was read is incomplete"))
            throw Error(error.kind(), fmt::format("{}: damaged: {}", path, text));
        if (text.ends_with(kClaimsMemory) && limitsMemory(LoadOptions::kLeastMemory))
            throw Error(ErrorKind::memory,
                        fmt::format("{}: not enough memory to read it; raise the limit (ulimit -v)", path));
        if (text.starts_with("cannot hand over")) throw Error(error.kind(), fmt::format("{}: {}", path, text));
        throw;
    }
}

/// Runs `load`, and once more if the loader program had just been ended by somebody.
template <typename Load>
auto withLoader(const Checkpoint& checkpoint, const Load& load) {
    if (checkpoint) checkpoint();
    try {
        return load();
    } catch (const LoaderLost&) {
        return load();
    }
}

/// Starts a child of this kind that reads a file as `request` says, and receives the result, or
/// what the file's problem is.
template <typename Result>
Result fileJob(LoadedFiles files, const Kind& kind, const LoadRequest& request, Result (*receive)(int),
               const LoadOptions& options, const Checkpoint& checkpoint) {
    const std::string& path = request.path;
    const OpenFile file(path);
    if (!file.problem().empty()) {
        Result none;
        none.problem = files == LoadedFiles::pictures ? file.problem() : fmt::format("{}: {}", path, file.problem());
        return none;
    }
    return withLoader(checkpoint, [&] {
        const Descriptor transfer(createTransfer());
        sendRequest(transfer.fd(), request);
        LoadJob(options.loader, files, path, {transfer.fd(), file.fd()}, limitsFor(kind, file.size(), options),
                options.showStderr)
            .wait(checkpoint);
        return received(path, [&] { return receive(transfer.fd()); });
    });
}

template <typename Result>
Result pictureJob(const std::string& path, LoadTask task, Result (*receive)(int), const LoadOptions& options,
                  const Checkpoint& checkpoint) {
    return fileJob(LoadedFiles::pictures, kPicture, {path, std::move(task)}, receive, options, checkpoint);
}

}  // namespace

GuardedFields::GuardedFields(const std::string& path, const std::vector<GridRequest>& requests,
                             const LoadOptions& options, const GridEdit* edit)
    : m_path(path),
      m_requests(requests),
      m_edit(edit == nullptr ? std::nullopt : std::optional(*edit)),
      m_identities(identities()),
      m_transfer(createTransfer()),
      m_job(begin(path, FieldsTask{requests, loadEdit(edit)}, options, m_transfer.fd())) {}

GuardedFields::Identity GuardedFields::identityOf(const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    return {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino),
            static_cast<std::uint64_t>(status.st_size), static_cast<std::int64_t>(status.st_mtim.tv_sec),
            static_cast<std::int64_t>(status.st_mtim.tv_nsec)};
}

std::vector<GuardedFields::Identity> GuardedFields::identities() const {
    std::vector<Identity> all{identityOf(m_path)};
    for (std::size_t i = 1; m_edit && i < m_edit->files.size(); ++i) all.push_back(identityOf(m_edit->files[i]));
    return all;
}

bool GuardedFields::isCurrent() const {
    return identities() == m_identities;
}

std::vector<SparseField> GuardedFields::take(const MessageSink& messages, const Checkpoint& checkpoint) {
    m_job.wait(checkpoint);
    ReceivedFields result = received(m_path, [&] { return receiveFields(m_transfer.fd()); });
    if (result.fields.size() != m_requests.size())
        throw Error(ErrorKind::input, fmt::format("{}: damaged: {} grids were read, expected {}", m_path,
                                                  result.fields.size(), m_requests.size()));
    for (const TransferMessage& message : result.messages) notify(messages, message.severity, message.text);
    return std::move(result.fields);
}

std::vector<SparseField> guardedFields(const std::string& path, const std::vector<GridRequest>& requests,
                                       const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint, const GridEdit* edit) {
    return withLoader(checkpoint,
                      [&] { return GuardedFields(path, requests, options, edit).take(messages, checkpoint); });
}

std::vector<SparseField> guardedEdit(const std::vector<SparseField>& grids, const std::string& name,
                                     const std::vector<GridRequest>& requests, const GridEdit& edit,
                                     const LoadOptions& options, const MessageSink& messages,
                                     const Checkpoint& checkpoint) {
    std::uint64_t bytes = 0;
    for (const SparseField& grid : grids) bytes += grid.bytes();
    const std::string what = workOn(name, &edit);
    ReceivedFields result = withLoader(checkpoint, [&] {
        const Descriptor transfer(createTransfer()), made(createTransfer());
        sendFields(made.fd(), grids, {});
        sendRequest(transfer.fd(), {name, MadeFieldsTask{requests, loadEdit(edit)}});
        LoadJob(options.loader, LoadedFiles::volumes, what, {transfer.fd(), made.fd()},
                limitsFor(kEdited, bytes, options), options.showStderr)
            .wait(checkpoint);
        return received(what, [&] { return receiveFields(transfer.fd()); });
    });
    if (result.fields.size() != requests.size())
        throw Error(ErrorKind::input, fmt::format("{}: damaged: {} grids were made, expected {}", what,
                                                  result.fields.size(), requests.size()));
    for (const TransferMessage& message : result.messages) notify(messages, message.severity, message.text);
    return std::move(result.fields);
}

VdbFileInfo guardedInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint,
                        const GridEdit* edit) {
    return withLoader(checkpoint, [&] {
        const Descriptor transfer(createTransfer());
        begin(path, InfoTask{loadEdit(edit)}, options, transfer.fd()).wait(checkpoint);
        return received(path, [&] { return receiveInfo(transfer.fd()); });
    });
}

std::string guardedFile(const std::string& path, const GridEdit& edit, const LoadOptions& options,
                        const MessageSink& messages, const Checkpoint& checkpoint) {
    return withLoader(checkpoint, [&] {
        const Descriptor transfer(createTransfer());
        begin(path, EditedFileTask{loadEdit(edit)}, options, transfer.fd()).wait(checkpoint);
        auto [bytes, said] = received(path, [&] { return receiveFile(transfer.fd()); });
        for (const TransferMessage& message : said) notify(messages, message.severity, message.text);
        return std::move(bytes);
    });
}

FilePicture guardedPicture(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    return pictureJob<FilePicture>(path, PictureTask(), receivePicture, options, checkpoint);
}

PictureHeader guardedHeader(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    return pictureJob<PictureHeader>(path, HeaderTask(), receivePictureHeader, options, checkpoint);
}

FileDepth guardedDepth(const std::string& path, const std::string& channel, const LoadOptions& options,
                       const Checkpoint& checkpoint) {
    return pictureJob<FileDepth>(path, DepthTask{channel}, receivePictureDepth, options, checkpoint);
}

FileMesh guardedMesh(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    return fileJob(LoadedFiles::volumes, kSource, {path, MeshTask{besideLibrary(kMeshModule)}}, receiveMesh, options,
                   checkpoint);
}

FilePhotometry guardedPhotometry(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    return fileJob(LoadedFiles::volumes, kPicture, {path, PhotometryTask()}, receivePhotometry, options, checkpoint);
}

std::vector<SparseField> guardedSource(const std::string& source, const SourceParameters& parameters,
                                       const std::string& path, const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint) {
    const std::string what = fmt::format("source '{}': {}", sourceNameOf(source), path);
    std::optional<FolderFile> files;
    std::optional<OpenFile> file;
    std::error_code ignored;
    const std::filesystem::path own(path);
    const bool isMany = isPattern(path);
    if (!isMany && !std::filesystem::is_directory(path, ignored)) {
        file.emplace(path);
        if (!file->problem().empty()) throw Error(ErrorKind::input, fmt::format("{}: {}", what, file->problem()));
    }
    if (isMany)
        files.emplace(own.has_parent_path() ? own.parent_path().string() : ".", own.filename().string(), checkpoint);
    else if (const std::optional<std::string> folder = file ? folderOf(path, *file) : path)
        files.emplace(*folder, "", checkpoint);
    const int input = files ? files->fd() : file->fd();
    const std::uint64_t size = files ? files->size() : file->size();
    SourceTask task{source, parameters};
    const auto madeWith = [&](const OpenFile* beside) {
        const std::uint64_t bytes = size + (beside == nullptr ? 0 : beside->size());
        return withLoader(checkpoint, [&] {
            const Descriptor transfer(createTransfer());
            sendRequest(transfer.fd(), {path, task});
            LoadJob(options.loader, LoadedFiles::volumes, what,
                    {transfer.fd(), input, beside == nullptr ? -1 : beside->fd()}, limitsFor(kSource, bytes, options),
                    options.showStderr)
                .wait(checkpoint);
            return received(what, [&] { return receiveFields(transfer.fd()); });
        });
    };
    const auto made = [&] {
        try {
            return madeWith(nullptr);
        } catch (const BesideError& error) {
            // Only now is the name of the second file known.
            task.beside = error.name();
            const OpenFile beside((std::filesystem::path(path).parent_path() / error.name()).string());
            if (!beside.problem().empty()) throw;
            return madeWith(&beside);
        } catch (const ReaderCrash& crash) {
            // GDCM ends its process where a damaged file is not as it assumes.
            if (!files || !files->isDicom()) throw;
            throw Error(crash.kind(),
                        fmt::format("{}: is not readable as DICOM: {} stopped on it ({})", what,
                                    sourceNameOf(source) == "scan" ? "GDCM" : "its reader", crash.signal()));
        }
    };
    ReceivedFields result = made();
    if (result.fields.empty()) throw Error(ErrorKind::input, fmt::format("{}: damaged: no grid was made", what));
    for (const TransferMessage& message : result.messages) notify(messages, message.severity, message.text);
    return std::move(result.fields);
}

}  // namespace scrim
