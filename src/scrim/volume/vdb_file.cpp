// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_file.h>

#include <scrim/volume/vdb_module.h>

namespace scrim {

VdbFile VdbFile::open(const std::string& path) {
    return open(VdbBytes(path));
}

VdbFile VdbFile::open(const std::string& path, const std::vector<GridRequest>& requests) {
    return open(VdbBytes(path), requests);
}

VdbFile VdbFile::open(const VdbBytes& bytes) {
    return VdbFile(vdbModule().read(bytes, nullptr, nullptr, {}));
}

VdbFile VdbFile::open(const VdbBytes& bytes, const std::vector<GridRequest>& requests) {
    return VdbFile(vdbModule().read(bytes, &requests, nullptr, {}));
}

VdbFile VdbFile::open(const VdbBytes& bytes, const std::vector<GridRequest>& requests, BlockMemory& memory,
                      const PointLook& look) {
    return VdbFile(vdbModule().read(bytes, &requests, &memory, look));
}

VdbFile VdbFile::open(const VdbFiles& files, const std::vector<GridRequest>& requests, const GridEditor& editor,
                      const MessageSink& messages) {
    return VdbFile(vdbModule().readEdited(files, &requests, editor, messages));
}

VdbFile VdbFile::open(const VdbFiles& files, const GridEditor& editor, const MessageSink& messages) {
    return VdbFile(vdbModule().readEdited(files, nullptr, editor, messages));
}

VdbFile VdbFile::of(const std::vector<SparseField>& fields, const std::string& name, const GridEditor& editor,
                    const MessageSink& messages) {
    return VdbFile(vdbModule().editFields(fields, name, editor, messages));
}

VdbFileInfo VdbFile::info() const {
    return m_content->info();
}

std::string VdbFile::asFile() const {
    return m_content->asFile();
}

std::vector<std::string> VdbFile::usableGrids() const {
    return m_content->usableGrids();
}

SparseField VdbFile::field(const GridRequest& request, const MessageSink& messages) const {
    return m_content->field(request, messages);
}

SparseField VdbFile::lastField(const GridRequest& request, const MessageSink& messages) {
    return m_content->lastField(request, messages);
}

VdbFile::VdbFile(std::unique_ptr<Content> content) : m_content(std::move(content)) {}
VdbFile::VdbFile(VdbFile&&) noexcept = default;
VdbFile& VdbFile::operator=(VdbFile&&) noexcept = default;
VdbFile::~VdbFile() = default;

}  // namespace scrim
