// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/field_transfer.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_info_text.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace scrim {

namespace {

/// Each field consists of a FieldHeader, the name, origins and tiles. The values of its blocks lie before the contents.
struct FieldHeader {
    std::uint64_t valuesAt = 0;
    std::uint64_t blocks = 0;
    std::uint64_t tiles = 0;
    std::uint64_t nonFinite = 0;
    std::uint64_t negative = 0;
    double wsFromIs[16] = {};  ///< column by column, as in GLM
};

struct TileRecord {
    std::int32_t origin[3];
    std::int32_t edge;
    float value;
};

/// What is known about some blocks from another process.
struct Part {
    std::uint64_t active = 0;
    float maxValue = 0;
    bool good = true;  ///< all values are finite and not negative

    void add(const float* block) {
        // Written so that compilers vectorise it: the bits of floats that are neither negative nor
        // NaN have their order.
        constexpr auto kLargest = std::bit_cast<std::int32_t>(std::numeric_limits<float>::max());
        std::int32_t positive = 0, largest = 0, least = 0;
        for (int i = 0; i < kBlockVoxels; ++i) {
            const auto bits = std::bit_cast<std::int32_t>(block[i]);
            positive += bits > 0;
            largest = std::max(largest, bits);
            least = std::min(least, bits);
        }
        active += static_cast<std::uint64_t>(positive);
        good = good && least == 0 && largest <= kLargest;
        maxValue = std::max(maxValue, std::bit_cast<float>(largest));
    }
};

/// Checks in blocks from another process what `buildField` promises about values: counts them, and
/// returns whether all are finite and not negative.
bool countBlocks(SparseField& field) {
    constexpr std::size_t kBlocksPerTask = 256;
    std::vector<Part> parts((field.blockCount() + kBlocksPerTask - 1) / kBlocksPerTask);
    parallelFor(parts.size(), [&](std::size_t task) {
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i) parts[task].add(field.block(i));
    });
    bool good = true;
    for (const Part& part : parts) {
        good = good && part.good;
        field.activeVoxels += part.active;
        field.maxValue = std::max(field.maxValue, part.maxValue);
    }
    return good;
}

SparseField readField(TransferReader& reader, const std::shared_ptr<const TransferMapping>& mapping) {
    const auto header = reader.value<FieldHeader>();
    SparseField field;
    field.name = reader.text();
    field.nonFinite = header.nonFinite;
    field.negative = header.negative;
    FieldPieces frame;  // everything but the values, to be checked as for any other field
    frame.name = field.name;
    for (int i = 0; i < 16; ++i) frame.wsFromIs[i / 4][i % 4] = header.wsFromIs[i];
    field.wsFromIs = frame.wsFromIs;

    const char* origins = reader.take(header.blocks, sizeof(Int3));
    field.blockOrigins.resize(header.blocks);
    if (header.blocks > 0) std::memcpy(field.blockOrigins.data(), origins, header.blocks * sizeof(Int3));
    const char* tiles = reader.take(header.tiles, sizeof(TileRecord));
    for (std::uint64_t i = 0; i < header.tiles; ++i) {
        TileRecord t;
        std::memcpy(&t, tiles + i * sizeof t, sizeof t);
        field.tiles.push_back({{t.origin[0], t.origin[1], t.origin[2]}, t.edge, t.value});
        if (!(std::isfinite(t.value) && t.value > 0)) incompleteTransfer("a tile holds a value that is not above 0");
    }
    field.blockValues = std::shared_ptr<const float>(mapping, reader.blocks(header.valuesAt, header.blocks));

    if (!std::is_sorted(field.blockOrigins.begin(), field.blockOrigins.end(), originLess))
        incompleteTransfer("its blocks are out of order");
    frame.blockOrigins = field.blockOrigins;
    frame.tiles = field.tiles;
    try {
        checkPieces(frame);
    } catch (const Error& error) {
        incompleteTransfer(error.what());
    }
    if (!countBlocks(field)) incompleteTransfer("its blocks hold values that are negative or not finite");
    for (const ConstantTile& tile : field.tiles) {
        const auto edge = static_cast<std::uint64_t>(tile.edge);
        field.activeVoxels += edge * edge * edge;
        field.maxValue = std::max(field.maxValue, tile.value);
    }
    return field;
}

void sendMessages(TransferWriter& writer, const std::vector<TransferMessage>& messages) {
    for (const TransferMessage& message : messages) {
        writer.value(static_cast<std::uint32_t>(message.severity));
        writer.text(message.text);
    }
}

/// `valuesAt` is the position of the field's values.
void sendField(TransferWriter& writer, const SparseField& field, std::uint64_t valuesAt) {
    FieldHeader header;
    header.valuesAt = valuesAt;
    header.blocks = field.blockCount();
    header.tiles = field.tiles.size();
    header.nonFinite = field.nonFinite;
    header.negative = field.negative;
    for (int i = 0; i < 16; ++i) header.wsFromIs[i] = field.wsFromIs[i / 4][i % 4];
    writer.value(header);
    writer.text(field.name);
    writer.bytes(field.blockOrigins.data(), field.blockOrigins.size() * sizeof(Int3));
    for (const ConstantTile& t : field.tiles)
        writer.value(TileRecord{{t.origin.x, t.origin.y, t.origin.z}, t.edge, t.value});
}

std::vector<TransferMessage> receiveMessages(TransferReader& reader, const TransferHeader& header) {
    std::vector<TransferMessage> messages;
    for (std::uint64_t i = 0; i < header.messages; ++i) {
        const auto severity = reader.value<std::uint32_t>();
        messages.push_back({severity == 0 ? Severity::info : Severity::warning, shortened(reader.text(), 2000)});
    }
    return messages;
}

}  // namespace

void sendFields(int fd, const std::vector<SparseField>& fields, const std::vector<TransferMessage>& messages,
                const TransferBlocks* blocks) {
    TransferWriter writer = blocks == nullptr ? TransferWriter(fd) : TransferWriter(*blocks);
    std::vector<std::uint64_t> places;
    for (const SparseField& field : fields) {
        const float* const values = field.blockValues.get();
        const auto place = blocks == nullptr ? std::nullopt : blocks->positionOf(values);
        places.push_back(place ? *place : writer.values(values, field.blockCount() * kBlockVoxels * sizeof(float)));
    }
    writer.beginContents();
    sendMessages(writer, messages);
    for (std::size_t i = 0; i < fields.size(); ++i) sendField(writer, fields[i], places[i]);
    TransferHeader header;
    header.fields = fields.size();
    header.messages = messages.size();
    writer.finish(header, TransferKind::fields);
}

void sendInfo(int fd, const VdbFileInfo& info) {
    TransferWriter writer(fd);
    writer.text(toJson(info));
    writer.finish({}, TransferKind::info);
}

void sendFile(int fd, const std::string& bytes, const std::vector<TransferMessage>& messages) {
    TransferWriter writer(fd);
    sendMessages(writer, messages);
    writer.text(bytes);
    TransferHeader header;
    header.messages = messages.size();
    writer.finish(header, TransferKind::file);
}

void sendError(int fd, const Error& error) {
    TransferWriter writer(fd);
    writer.text(error.what());
    TransferHeader header;
    header.code = static_cast<std::uint32_t>(error.kind());
    TransferKind kind = TransferKind::error;
    if (const auto* ofGrid = dynamic_cast<const GridError*>(&error)) {
        writer.text(toText(ofGrid->request()));
        kind = TransferKind::gridError;
    }
    if (const auto* beside = dynamic_cast<const BesideError*>(&error)) {
        writer.text(beside->name());
        kind = TransferKind::besideError;
    }
    writer.finish(header, kind);
}

ReceivedFields receiveFields(int fd) {
    const auto mapping = std::make_shared<const TransferMapping>(fd);
    TransferReader reader(*mapping);
    const TransferHeader header = reader.header(TransferKind::fields);
    ReceivedFields out;
    out.messages = receiveMessages(reader, header);
    for (std::uint64_t i = 0; i < header.fields; ++i) out.fields.push_back(readField(reader, mapping));
    if (!reader.done()) incompleteTransfer("it is longer than its header says");
    return out;
}

std::pair<std::string, std::vector<TransferMessage>> receiveFile(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    const TransferHeader header = reader.header(TransferKind::file);
    std::vector<TransferMessage> messages = receiveMessages(reader, header);
    return {reader.text(), std::move(messages)};
}

VdbFileInfo receiveInfo(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    reader.header(TransferKind::info);
    return vdbFileInfoFromJson(reader.text());
}

}  // namespace scrim
