// SPDX-License-Identifier: Apache-2.0
// Volume sources that read files, run by a confined process: whatever the sources of Scrim do with a good file, the
// filter allows it, and what a file that took over its reader would do, it does not.
#include "support/program_test.h"

#include <scrim/base/parallel.h>
#include <scrim/guard/load_request.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/load_fields.h>
#include <scrim/guard/load_job.h>
#include <scrim/volume/source.h>

#include "support/data.h"
#include "support/dicom_files.h"
#include "support/expect_error.h"
#include "support/loader_processes.h"
#include "support/source_files.h"
#include "support/tiff_files.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <locale>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim::test {
namespace {

const LoadOptions kGuarded{VolumeLoading::guarded, ""};

#ifdef SCRIM_SANITIZED
constexpr bool kFiltered = false;
#else
constexpr bool kFiltered = true;
#endif

void expectSame(const std::vector<SparseField>& there, const std::vector<SparseField>& here, const std::string& what) {
    ASSERT_EQ(there.size(), here.size()) << what;
    for (std::size_t i = 0; i < here.size(); ++i) {
        const SparseField &a = there[i], &b = here[i];
        EXPECT_EQ(a.name, b.name) << what;
        EXPECT_EQ(a.wsFromIs, b.wsFromIs) << what;
        EXPECT_EQ(a.activeVoxels, b.activeVoxels) << what;
        EXPECT_EQ(a.maxValue, b.maxValue) << what;
        EXPECT_EQ(a.nonFinite, b.nonFinite) << what;
        EXPECT_EQ(a.negative, b.negative) << what;
        EXPECT_GT(a.activeVoxels, 0u) << what;
        ASSERT_EQ(a.blockOrigins, b.blockOrigins) << what;
        EXPECT_EQ(std::memcmp(a.block(0), b.block(0), b.blockCount() * kBlockVoxels * sizeof(float)), 0) << what;
        ASSERT_EQ(a.tiles.size(), b.tiles.size()) << what;
        for (std::size_t t = 0; t < b.tiles.size(); ++t) {
            EXPECT_EQ(a.tiles[t].origin, b.tiles[t].origin) << what;
            EXPECT_EQ(a.tiles[t].edge, b.tiles[t].edge) << what;
            EXPECT_EQ(a.tiles[t].value, b.tiles[t].value) << what;
        }
    }
}

class SourceLoader : public ProgramTest {
  protected:
    void SetUp() override { ::setenv("SCRIM_PLUGIN_PATH", SCRIM_BUILT_SOURCES ":" SCRIM_BAD_SOURCES, 1); }
    void TearDown() override { ::unsetenv("SCRIM_PLUGIN_PATH"); }

    SourceParameters with(const std::string& name, SourceParameters more) const {
        more.insert(more.begin(), {"file", name.starts_with('/') ? name : file(name)});
        return more;
    }
    /// The same fields, and the same words about them.
    void expectSameFields(const std::string& source, const std::string& name, SourceParameters more = {}) const {
        const SourceParameters parameters = with(name, std::move(more));
        std::vector<std::string> saidHere, saidThere;
        const auto into = [](std::vector<std::string>& said) {
            return [&said](Severity, const std::string& text) { said.push_back(text); };
        };
        expectSame(sourceFields(source, parameters, kGuarded, into(saidThere)),
                   sourceFields(source, parameters, {}, into(saidHere)), name);
        EXPECT_EQ(saidThere, saidHere) << name;
    }
    std::string refused(const std::string& source, const std::string& name, const SourceParameters& more = {},
                        const LoadOptions& options = kGuarded) const {
        return errorOf(ErrorKind::input, [&] { sourceFields(source, with(name, more), options, {}); });
    }
    void expectSameRefusal(const std::string& source, const std::string& name,
                           const SourceParameters& more = {}) const {
        const std::string there = refused(source, name, more);
        EXPECT_EQ(there, refused(source, name, more, {}));
        EXPECT_TRUE(there.starts_with("source '" + source + "': ")) << there;
    }
    /// "source 'readsfile': PATH: damaged: reading it crashed (...)", without what stands before "damaged".
    std::string told(const std::string& act) const {
        const std::string text = refused("readsfile", "in", {{"act", act}});
        const std::size_t at = text.find("damaged: ");
        EXPECT_EQ(text.rfind("source 'readsfile': ", 0), 0u) << text;
        return at == std::string::npos ? text.substr(20) : text.substr(at);
    }
    void makeScans() const;
};

/// 8 x 8 x 10 bytes, some 0 and a constant block among them.
std::string samples() {
    std::string bytes;
    for (int i = 0; i < 640; ++i) bytes += static_cast<char>(i < 512 ? i % 3 == 0 ? 0 : i * 7 : 9);
    return bytes;
}

std::string nrrdHead(const std::string& fields) {
    return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 10\nspacings: 1 2 3\n" + fields;
}

void SourceLoader::makeScans() const {
    write("raw.nrrd", nrrdHead("encoding: raw\n\n") + samples());
    write("gzip.nrrd", nrrdHead("encoding: gzip\n\n") + gzipped(samples()));
    std::string text;
    for (const char c : samples()) text += std::to_string(static_cast<unsigned char>(c)) + " ";
    write("text.nrrd", nrrdHead("encoding: ascii\n\n") + text);
    write("samples.bin", samples());
    write("samples.bin.gz", gzipped(samples()));
    write("apart.nhdr", nrrdHead("encoding: raw\ndata file: samples.bin\n"));
    write("apart_here.nhdr", nrrdHead("encoding: raw\ndata file: ./samples.bin\n"));
    write("apart_gzip.nhdr", nrrdHead("encoding: gzip\ndata file: samples.bin.gz\n"));
    NiftiHeader nifti;
    nifti.dims[1] = nifti.dims[2] = 8;
    nifti.dims[3] = 10;
    nifti.sform = true;
    write("a.nii", nifti.bytes() + samples());
    write("a.nii.gz", gzipped(nifti.bytes() + samples()));
    const std::string meta = "NDims = 3\nDimSize = 8 8 10\nElementType = MET_UCHAR\nElementDataFile = ";
    write("a.mha", meta + "LOCAL\n" + samples());
    write("a.mhd", meta + "samples.bin\n");
    // A stream of zlib is that of gzip without its 10 bytes of header and 8 at the end, with 2 and 4 in their places.
    const std::string packed = gzipped(samples());
    uLong check = adler32(0, nullptr, 0);
    check = adler32(check, reinterpret_cast<const Bytef*>(samples().data()), static_cast<uInt>(samples().size()));
    std::string zlib = "\x78\x9c" + packed.substr(10, packed.size() - 18);
    for (const int shift : {24, 16, 8, 0}) zlib += static_cast<char>(check >> shift & 0xff);
    write("zip.mha", "CompressedData = True\n" + meta + "LOCAL\n" + zlib);
    const std::string array = "{'descr': '|u1', 'fortran_order': False, 'shape': (8, 8, 10), }\n";
    write("a.npy",
          std::string("\x93NUMPY\1\0", 8) + std::string{static_cast<char>(array.size()), 0} + array + samples());
    nifti.pair = true;
    write("pair.hdr", nifti.bytes());
    write("pair.img", samples());
}

TEST_F(SourceLoader, ReadsEveryKindOfScanAsThisProcessDoes) {
    makeScans();
    for (const char* name : {"raw.nrrd", "gzip.nrrd", "text.nrrd", "apart.nhdr", "apart_here.nhdr", "apart_gzip.nhdr",
                             "a.nii", "a.nii.gz", "pair.hdr", "a.mha", "zip.mha", "a.mhd", "a.npy"})
        expectSameFields("scan", name, {{"window", "full"}});
    for (const char* name : {"samples.bin", "samples.bin.gz"}) expectSameFields("scan", name, {{"size", "8, 8, 10"}});
    write("floats.raw", std::string("\0\0\x80\x3f\0\0\xc0\x7f\0\0\x80\xbf\0\0\0\x40", 16));  // 1, NaN, -1, 2
    expectSameFields("scan", "floats.raw", {{"size", "4, 1, 1"}, {"type", "float"}});
}

TEST_F(SourceLoader, ReadsSeriesOfFilesAsThisProcessDoes) {
    std::filesystem::create_directories(file("series"));
    for (int z = 0; z < 4; ++z) write("series/" + std::to_string(9 - z) + ".dcm", countingSlice(z).bytes());
    write("series/notes.txt", "not a slice");
    for (const char* name : {"series", "series/", "series/7.dcm"}) expectSameFields("scan", name);
    std::filesystem::remove(file("series/7.dcm"));
    expectSameRefusal("scan", "series");
    write("series/a.dcm", "nothing");
    for (const char* name : {"series/a.dcm", "series/none.dcm"}) expectSameRefusal("scan", name);
}

TEST_F(SourceLoader, ReadsStacksAndSlicesOfTiffAsThisProcessDoes) {
    write("stack.tif", countingPages().bytes());
    expectSameFields("scan", "stack.tif");
    std::filesystem::create_directories(file("slices"));
    for (int z = 0; z < 4; ++z) {
        write("slices/a" + std::to_string(8 + z) + ".tif", countingPages(z, 1).bytes());
        write("slices/b" + std::to_string(z) + ".tif", countingPages(z, 1).bytes());
    }
    expectSameRefusal("scan", "slices");
    for (const char* name : {"slices/a*.tif", "slices/b*.tif"}) expectSameFields("scan", name);
    for (const char* name : {"slices/c*.tif", "none/c*.tif"}) expectSameRefusal("scan", name);
    std::filesystem::remove(file("slices/a9.tif"));
    expectSameRefusal("scan", "slices/a*.tif");
    // DICOM comes first, and TIFF files are none of its business.
    for (int z = 0; z < 4; ++z) write("slices/" + std::to_string(9 - z), countingSlice(z).bytes());
    expectSameFields("scan", "slices");
}

// GDCM asserts what it expects of a file, and so ends the process that reads one cut off in its first group.
TEST_F(SourceLoader, ADicomFileThatEndsItsReaderIsCalledUnreadable) {
    const std::string whole = countingSlice(0).bytes();
    ASSERT_GT(whole.size(), 140u);
    std::filesystem::create_directories(file("series"));
    write("series/a.dcm", whole.substr(0, 140));
    for (const char* name : {"series/a.dcm", "series"})
        EXPECT_EQ(refused("scan", name),
                  "source 'scan': " + file(name) + ": is not readable as DICOM: GDCM stopped on it (signal SIGABRT)");
}

// A folder's DICOM files of more than 16 GB are refused, but not for the sake of a file that is none.
TEST_F(SourceLoader, AFolderIsNotCopiedForAFileThatIsNotDicom) {
    write("notes.dcm", "nothing");
    write("large", std::string(128, '\0') + "DICM");
    std::filesystem::resize_file(file("large"), std::uintmax_t{17} << 30);  // takes no place on the disk
    EXPECT_EQ(refused("scan", "notes.dcm"),
              "source 'scan': " + file("notes.dcm") + ": is not a DICOM file, or holds no picture");
}

TEST_F(SourceLoader, ReadsEveryKindOfMeshAsThisProcessDoes) {
    write("cube.obj", std::string("mtllib cube.mtl\n") + kCubeObj);
    write("cube.mtl", "newmtl red\nKd 1 0 0\n");
    expectSameFields("mesh", "cube.obj", {{"resolution", "40"}});
    expectSameFields("mesh", "cube.obj", {{"voxel", "0.02"}, {"soft", "0.1"}, {"fill", "false"}});
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        write("cube.ply", cubePly(format));
        expectSameFields("mesh", "cube.ply", {{"resolution", "24"}});
    }
}

TEST_F(SourceLoader, ReadsRealScansAsThisProcessDoes) {
    for (const char* name : {"bonsai_256.nrrd", "ch2bet.nii.gz", "tooth.raw"})
        SCRIM_NEEDS_DATA(std::string("scan/") + name);
    for (const char* name : {"bonsai_256.nrrd", "ch2bet.nii.gz", "tooth.nhdr"})
        expectSameFields("scan", dataFile(std::string("scan/") + name), {{"threshold", "20"}});
}

TEST_F(SourceLoader, ReadsFilesOfTheWorkingFolder) {
    makeScans();
    for (const char* folder : {"here", "there"}) std::filesystem::create_directories(file(folder));
    for (const std::string part : {"apart.nhdr", "samples.bin"})
        std::filesystem::copy_file(file(part), file("here/" + part));
    for (const auto& [folder, name] : {std::pair<const char*, std::string>{"here", "apart.nhdr"},
                                       {"here", "./apart.nhdr"},
                                       {"there", "../here/apart.nhdr"},
                                       {"there", ".././/here/./apart.nhdr"},
                                       {"there", file("there") + "/../here/apart.nhdr"}}) {
        const ProgramResult result = runProgram(file(folder), {"make", "scan", "file=" + name, "-o", "x.vdb", "-q"});
        EXPECT_EQ(result.status, 0) << name << ": " << result.err;
    }
}

TEST_F(SourceLoader, SaysWhatThisProcessSaysOfBadFiles) {
    makeScans();
    std::filesystem::create_directories(file("folder.nrrd"));
    for (const char* name : {"none.nrrd", "folder.nrrd"}) expectSameRefusal("scan", name);
    expectSameRefusal("scan", "a.nii", {{"size", "8, 8, 10"}});
    expectSameRefusal("scan", "a.nii", {{"sise", "8, 8, 10"}});
    expectSameRefusal("scan", "samples.bin", {{"size", "8, 8, 11"}});
    write("cut.nrrd", nrrdHead("encoding: raw\n\n") + samples().substr(9));
    write("lost.nhdr", nrrdHead("encoding: raw\ndata file: none.bin\n"));
    write("few.nhdr", nrrdHead("encoding: raw\ndata file: few.bin\n"));
    write("few.bin", "abc");
    write("junk.nii", std::string(400, 'x'));
    write("slices.nhdr", nrrdHead("encoding: raw\ndata file: s%03d.bin 0 9 1\n"));
    write("list.nhdr", nrrdHead("encoding: raw\ndata file: LIST\nsamples.bin\nfew.bin\n"));
    for (const char* name : {"cut.nrrd", "lost.nhdr", "few.nhdr", "junk.nii", "slices.nhdr", "list.nhdr"})
        expectSameRefusal("scan", name);
    write("x.stl", "solid\nendsolid\n");
    write("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (const char* name : {"none.ply", "x.stl", "far.obj", "open.obj"}) expectSameRefusal("mesh", name);
}

// A process with threads that is forked, and goes on as itself, waits for ever for the locks that other threads held
// then: here the one of the locale, which whoever reads or writes numbers asks for.
TEST_F(SourceLoader, ThreadsOfTheHostMayHoldLocks) {
    write("cube.obj", kCubeObj);
    constexpr unsigned kPatience = 60;  // seconds, after which the test ends by a signal
    ::alarm(kPatience);
    std::atomic<bool> done{false};
    std::thread host([&] {
        const std::locale own(std::locale::classic(), new std::numpunct<char>);
        while (!done)
            for (const std::locale& other : {own, std::locale::classic(), own}) std::locale::global(other);
        std::locale::global(std::locale::classic());
    });
    constexpr int kLoads = 200, kGuardedLoads = 5;
    for (int i = 0; i < kLoads; ++i) {
        EXPECT_FALSE(loadMesh(file("cube.obj"), {}).triangles.empty());
        if (i % 20 != 0) continue;
        EXPECT_GT(sourceFields("mesh", with("cube.obj", {{"resolution", "8"}}), {}, {}).at(0).activeVoxels, 0u);
    }
    for (int i = 0; i < kGuardedLoads; ++i) EXPECT_FALSE(loadMesh(file("cube.obj"), kGuarded).triangles.empty());
    done = true;
    host.join();
    ::alarm(0);
}

TEST_F(SourceLoader, FilesOfOneFolderBelongTogetherAndNoOthers) {
    makeScans();
    std::filesystem::create_directories(file("sub"));
    write("sub/samples.bin", samples());
    for (const std::string below : {"sub/samples.bin", "./sub/samples.bin", "sub/./samples.bin"}) {
        write("below.nhdr", nrrdHead("encoding: raw\ndata file: " + below + "\n"));
        expectSameFields("scan", "below.nhdr");
    }
    for (const std::string& elsewhere : {std::string("../samples.bin"), std::string("sub/../../samples.bin"),
                                         file("samples.bin"), std::string("/etc/passwd")}) {
        write("elsewhere.nhdr", nrrdHead("encoding: raw\ndata file: " + elsewhere + "\n"));
        expectSameRefusal("scan", "elsewhere.nhdr");
        EXPECT_EQ(refused("scan", "elsewhere.nhdr"), "source 'scan': " + file("elsewhere.nhdr") +
                                                         ": its samples are in '" + elsewhere +
                                                         "', expected a file in its own folder or below");
    }
    // Whoever may read the folder made the link.
    std::filesystem::create_symlink(file("sub/samples.bin"), file("link.bin"));
    write("link.nhdr", nrrdHead("encoding: raw\ndata file: link.bin\n"));
    expectSameFields("scan", "link.nhdr");
    // A pipe would never end.
    ASSERT_EQ(::mkfifo(file("pipe.bin").c_str(), 0600), 0);
    if (!kFiltered) return;
    write("pipe.nhdr", nrrdHead("encoding: raw\ndata file: pipe.bin\n"));
    EXPECT_NE(refused("scan", "pipe.nhdr").find("couldn't open"), std::string::npos);
    ASSERT_EQ(::mkfifo(file("pipe.nrrd").c_str(), 0600), 0);
    EXPECT_EQ(refused("scan", "pipe.nrrd"), "source 'scan': " + file("pipe.nrrd") + ": is not a file");
}

TEST_F(SourceLoader, RunsSourcesThatReadFilesAndNoOthers) {
    write("in", "abc");
    EXPECT_EQ(told("say whether alone"), "alone");
    EXPECT_EQ(refused("readsfile", "in", {{"act", "say whether alone"}}, {}), "source 'readsfile': not alone");
    EXPECT_EQ(errorOf(ErrorKind::input,
                      [] {
                          sourceFields("readsfile", {{"act", "say whether alone"}}, kGuarded, {});
                      }),
              "source 'readsfile': not alone");
    expectSameFields("readsfile", "in", {{"act", "warn"}});
    EXPECT_EQ(told("nothing"), "it made no grid");
}

TEST_F(SourceLoader, OutlivesFilesThatCrashTheirReader) {
    write("in", "abc");
    expectSameFields("readsfile", "in");
    if (!kFiltered) return;  // sanitizers handle these signals
    EXPECT_EQ(told("crash"), "damaged: reading it crashed (signal SIGSEGV)");
    EXPECT_EQ(told("abort"), "damaged: reading it crashed (signal SIGABRT)");
    LoadOptions little = kGuarded;
    little.memory = std::size_t{1} << 30;
    EXPECT_EQ(refused("readsfile", "in", {{"act", "eat memory"}}, little), "source 'readsfile': not enough memory");
    expectSameFields("readsfile", "in");
}

TEST_F(SourceLoader, KeepsFilesThatTakeOverTheirReaderFromDoingAnything) {
    if (!kFiltered) GTEST_SKIP() << "no filter: this is a build with a sanitizer";
    write("in", "abc");
    for (const char* act : {"make a socket", "write"})
        EXPECT_EQ(told(act), "damaged: reading it crashed (signal SIGSYS)") << act;
    EXPECT_EQ(told("fork"), "no process");
    EXPECT_EQ(told("open another"), "nothing there");
    EXPECT_EQ(told("need one"), "no file 'one'");
    EXPECT_FALSE(exists("written"));
    write("one", "1");
    expectSameFields("readsfile", "in", {{"act", "need one"}});
    write("two", "2");
    EXPECT_EQ(told("need two"), "not both");
}

TEST_F(SourceLoader, StopsWhereItsCallerWantsTo) {
    write("in", "abc");
    const auto start = std::chrono::steady_clock::now();
    const auto stop = [&] {
        if (std::chrono::steady_clock::now() - start > std::chrono::milliseconds(200)) throw std::logic_error("stop");
    };
    for (const char* act : {"loop", "sleep"})
        EXPECT_THROW(sourceFields("readsfile", with("in", {{"act", act}}), kGuarded, {}, stop), std::logic_error);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

TEST_F(SourceLoader, ShowsTheSameInTheProgram) {
    makeScans();
    write("scene.toml", kCamera + "[[volume]]\nsource = \"scan\"\nparameters = { file = \"lost.nhdr\" }\n" + kLight);
    write("lost.nhdr", nrrdHead("encoding: raw\ndata file: ../none.bin\n"));
    expectFailure({"render", "scene.toml", "-o", "a.exr"}, 3,
                  "scene.toml:7:10: source 'scan': lost.nhdr: its samples are in '../none.bin', expected a file in its "
                  "own folder or below");
    write("lost.nhdr", nrrdHead("encoding: raw\ndata file: samples.bin\n"));
    runWell({"render", "scene.toml", "-o", "a.exr", "-q"});
}

// A child that neither ends nor computes, and one that computes for ever.
class StuckChild : public SourceLoader {
  protected:
    /// Is there a child of the program that this process started?
    static bool isThere() {
        const std::vector<LoaderProcess> all = loaderProcesses();
        for (const LoaderProcess& child : all)
            for (const LoaderProcess& program : all)
                if (child.parent == program.id && program.parent == ::getpid()) return true;
        return false;
    }
    static bool isGone() { return !isThere(); }
    /// A second of processor time is what the child has, and a second is how long its caller waits. `computes`: its
    /// caller begins to wait when the child has had its time, or else chance would have it which of the two ends first.
    static void expectEnded(LoadedFiles files, const LoadRequest& request, int input, bool computes = false) {
        ASSERT_TRUE(comesTrue(isGone));  // that of the test before
        const Descriptor transfer(createTransfer());
        sendRequest(transfer.fd(), request);
        const LoadLimits limits{std::size_t{1} << 30, std::chrono::seconds{1}};
        std::optional<LoadJob> job;
        // Each thread that a source may have adds a second: it may have one.
        TaskArena(1).run([&] {
            job.emplace("", files, request.path, LoadJob::Descriptors{transfer.fd(), input}, limits, false);
        });
        if (computes) {
            ASSERT_TRUE(comesTrue(isThere));
            ASSERT_TRUE(comesTrue(isGone));
        }
        EXPECT_EQ(errorOf(ErrorKind::input, [&] { job->wait({}); }),
                  request.path + (computes ? ": reading it did not finish within 1 second of CPU time"
                                           : ": reading it took more than 1 second"));
        job.reset();
        EXPECT_TRUE(comesTrue(isGone));
    }
};

TEST_F(StuckChild, IsEndedWhereItReadsAPicture) {
    ASSERT_EQ(::mkfifo(file("pipe.png").c_str(), 0600), 0);
    const Descriptor input(::open(file("pipe.png").c_str(), O_RDWR | O_CLOEXEC));  // of which nothing ever comes
    expectEnded(LoadedFiles::pictures, {file("pipe.png"), PictureTask()}, input.fd());
}

TEST_F(StuckChild, IsEndedWhereASourceReadsAFile) {
    write("in", "abc");
    const Descriptor input(::open(file("in").c_str(), O_RDONLY | O_CLOEXEC));
    for (const std::string act : {"sleep", "loop"})
        expectEnded(LoadedFiles::volumes, {file("in"), SourceTask{sourceFile("readsfile"), with("in", {{"act", act}})}},
                    input.fd(), act == "loop");
}

}  // namespace
}  // namespace scrim::test
