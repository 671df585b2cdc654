// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/mesh_transfer.h>

#include <scrim/guard/transfer_file.h>

#include <cmath>
#include <cstdint>
#include <cstring>

namespace scrim {
namespace {

template <typename Item>
void sendItems(TransferWriter& writer, const std::vector<Item>& items) {
    writer.value(static_cast<std::uint64_t>(items.size()));
    writer.bytes(items.data(), items.size() * sizeof(Item));
}

template <typename Item>
void receiveItems(TransferReader& reader, std::vector<Item>& items) {
    const auto count = reader.value<std::uint64_t>();
    const char* bytes = reader.take(count, sizeof(Item));
    items.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(items.data()), bytes, count * sizeof(Item));
}

bool isFinite(const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

void sendMesh(int fd, const FileMesh& mesh) {
    TransferWriter writer(fd);
    writer.text(mesh.problem);
    sendItems(writer, mesh.mesh.points);
    sendItems(writer, mesh.mesh.triangles);
    writer.finish({}, TransferKind::mesh);
}

FileMesh receiveMesh(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    reader.header(TransferKind::mesh);
    FileMesh out;
    out.problem = shortened(reader.text(), 2000);
    receiveItems(reader, out.mesh.points);
    receiveItems(reader, out.mesh.triangles);
    if (!reader.done()) incompleteTransfer("it is longer than its header says");
    for (const Vec3& p : out.mesh.points)
        if (!isFinite(p)) incompleteTransfer("a point of its mesh is not finite");
    for (const auto& triangle : out.mesh.triangles)
        for (const std::uint32_t corner : triangle)
            if (corner >= out.mesh.points.size()) incompleteTransfer("a triangle refers to a missing point");
    return out;
}

}  // namespace scrim
