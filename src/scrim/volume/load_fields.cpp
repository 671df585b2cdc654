// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/load_fields.h>

#include <scrim/base/error.h>
#include <scrim/volume/guarded_load.h>
#include <scrim/volume/vdb_file.h>

#include <new>
#include <set>

namespace scrim {

std::vector<SparseField> readFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const MessageSink& messages) {
    const VdbFile file = VdbFile::open(path, requests);
    std::set<std::string> said;
    const auto sayOnce = [&](Severity severity, const std::string& text) {
        if (said.insert(text).second) notify(messages, severity, text);
    };
    std::vector<SparseField> fields;
    for (const GridRequest& request : requests) fields.push_back(file.field(request, sayOnce));
    return fields;
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

std::vector<SparseField> loadFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const LoadOptions& options, const MessageSink& messages,
                                    const Checkpoint& checkpoint) {
    if (options.volumes == VolumeLoading::guarded) return guardedFields(path, requests, options, messages, checkpoint);
    std::vector<SparseField> fields;
    readWithErrors(path, [&] { fields = readFields(path, requests, messages); });
    return fields;
}

VdbFileInfo loadInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    if (options.volumes == VolumeLoading::guarded) return guardedInfo(path, options, checkpoint);
    VdbFileInfo info;
    readWithErrors(path, [&] { info = VdbFile::open(path).info(); });
    return info;
}

}  // namespace scrim
