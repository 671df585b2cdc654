// SPDX-License-Identifier: Apache-2.0
// Reads meshes with Assimp, with all formats but OBJ and PLY switched off. Its readers crash or hang on many damaged
// files, so untrusted files are read in a separate process (VolumeLoading::guarded). No process is forked here, since a
// process with threads may hold locks that the fork would wait for forever.
#include "mesh.h"

#include "alone.h"
#include "ply_size.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <assimp/BaseImporter.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <fmt/format.h>

namespace mesh {
namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 31;  // the limit of Assimp's counters

// What a reader in a process of its own may use before its file counts as damaged: several times what sound files
// needed in tests (some 20 bytes per byte of the file, 20 MB per second).
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30, kMemoryPerByte = 100;
constexpr unsigned kSeconds = 3;
constexpr std::size_t kBytesPerSecond = 1'000'000;

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw std::runtime_error(path + ": " + reason);
}

std::string endingOf(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
    return ending;
}

std::string bytesOf(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (status.type() == std::filesystem::file_type::not_found) refuse(path, "there is no such file");
    if (error) refuse(path, error.message());
    if (status.type() != std::filesystem::file_type::regular) refuse(path, "is not a file");  // a pipe would never end
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) refuse(path, error.message());
    if (size > kMostBytes) refuse(path, fmt::format("has {} bytes, expected at most {}", size, kMostBytes));
    if (size == 0) refuse(path, "is empty");
    std::string bytes(size, '\0');
    std::ifstream in(path, std::ios::binary);
    if (!in.read(bytes.data(), static_cast<std::streamsize>(size))) refuse(path, "cannot be read");
    return bytes;
}

/// Removes every reader but the one for `ending`.
void keepReader(Assimp::Importer& importer, const std::string& ending) {
    std::vector<Assimp::BaseImporter*> others;
    for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
        const aiImporterDesc* description = importer.GetImporterInfo(i);
        const std::string_view endings = description != nullptr ? description->mFileExtensions : "";
        if (endings != ending.substr(1)) others.push_back(importer.GetImporter(i));
    }
    for (Assimp::BaseImporter* other : others) {
        importer.UnregisterLoader(other);
        delete other;  // the importer no longer owns it
    }
}

void append(const aiMesh& part, Mesh& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    if (mesh.points.size() + part.mNumVertices > std::numeric_limits<std::uint32_t>::max())
        throw std::runtime_error("has too many vertices");
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& v = part.mVertices[i];
        if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
            throw std::runtime_error(
                fmt::format("one of its vertices is {}, {}, {}, expected finite numbers", v.x, v.y, v.z));
        mesh.points.push_back({v.x, v.y, v.z});
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        const aiFace& face = part.mFaces[i];
        if (face.mNumIndices != 3) continue;  // skips points and lines
        std::array<std::uint32_t, 3> triangle{};
        for (unsigned k = 0; k < 3; ++k) {
            if (face.mIndices[k] >= part.mNumVertices)
                throw std::runtime_error(
                    fmt::format("a face names vertex {} of {}", face.mIndices[k] + 1, part.mNumVertices));
            triangle[k] = first + face.mIndices[k];
        }
        mesh.triangles.push_back(triangle);
    }
}

Mesh importMesh(const std::string& bytes, const std::string& ending) {
    Assimp::Importer importer;
    keepReader(importer, ending);
    const aiScene* scene =
        importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, ending.c_str() + 1);
    if (scene == nullptr) {
        const std::string_view reason = importer.GetErrorString();
        if (reason == std::bad_alloc().what()) throw std::bad_alloc();
        throw std::runtime_error(fmt::format("cannot be read: {}", reason.substr(0, 300)));
    }
    Mesh mesh;
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(*scene->mMeshes[i], mesh);
    return mesh;
}

/// Imports a mesh within the limits for such a file.
Mesh importAlone(const std::string& bytes, const std::string& ending) {
    const AloneLimits limits(kMemory + kMemoryPerByte * bytes.size(),
                             kSeconds + static_cast<unsigned>(bytes.size() / kBytesPerSecond));
    try {
        return importMesh(bytes, ending);
    } catch (const std::bad_alloc&) {
        if (limits.lackMemory()) throw;
        throw std::runtime_error("it needs more memory than a file of its size should");
    }
}

}  // namespace

Mesh readMesh(const std::string& path, bool alone) {
    const std::string ending = endingOf(path);
    if (ending != ".obj" && ending != ".ply") refuse(path, "expected a file that ends in .obj or .ply");
    const std::string bytes = bytesOf(path);
    Mesh mesh;
    try {
        if (ending == ".ply") checkPlySize(bytes);
        mesh = alone ? importAlone(bytes, ending) : importMesh(bytes, ending);
    } catch (const std::runtime_error& error) {
        refuse(path, error.what());
    }
    if (mesh.triangles.empty()) refuse(path, "has no triangles");
    return mesh;
}

}  // namespace mesh
