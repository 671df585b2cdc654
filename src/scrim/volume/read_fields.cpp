// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/read_fields.h>

#include <scrim/base/error.h>
#include <scrim/volume/vdb_file.h>

#include <new>
#include <set>

namespace scrim {

namespace {

std::vector<SparseField> fieldsOf(VdbFile file, const std::vector<GridRequest>& requests, const MessageSink& messages) {
    std::set<std::string> said;
    const auto sayOnce = [&](Severity severity, const std::string& text) {
        if (said.insert(text).second) notify(messages, severity, text);
    };
    std::vector<SparseField> fields;
    for (const GridRequest& request : requests)
        fields.push_back(requests.size() == 1 ? file.lastField(request, sayOnce) : file.field(request, sayOnce));
    return fields;
}

}  // namespace

std::vector<SparseField> readFields(const VdbBytes& bytes, const std::vector<GridRequest>& requests,
                                    const MessageSink& messages, BlockMemory& memory, const PointLook& look) {
    return fieldsOf(VdbFile::open(bytes, requests, memory, look), requests, messages);
}

std::vector<SparseField> readFields(const VdbFiles& files, const std::vector<GridRequest>& requests,
                                    const GridEditor& editor, const MessageSink& messages) {
    return fieldsOf(VdbFile::open(files, requests, editor, messages), requests, messages);
}

std::vector<SparseField> editFields(const std::vector<SparseField>& grids, const std::string& name,
                                    const std::vector<GridRequest>& requests, const GridEditor& editor,
                                    const MessageSink& messages) {
    return fieldsOf(VdbFile::of(grids, name, editor, messages), requests, messages);
}

void readWithErrors(const std::string& path, const std::function<void()>& task) {
    try {
        task();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, path + ": not enough memory to read it");
    } catch (const std::exception& error) {
        throw Error(ErrorKind::input, path + ": damaged: " + shortened(error.what()));
    }
}

}  // namespace scrim
