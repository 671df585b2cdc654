// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

namespace scrim {

SceneMesh readMesh(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    const MeshKeys& k = keysOf<MeshKeys>();
    SceneMesh mesh;
    mesh.name = readName(table, k.name, defaultName);
    const TomlValue file = table.require(k.file);
    mesh.where = file.where();
    mesh.sequence = context.path(file);
    mesh.file = mesh.sequence.at(context.fileFrame());
    if (const auto transform = table.find(k.transform))
        mesh.wsFromMesh =
            readTransform(transform->table(fmt::format("{} of {}", k.transform, table.description())), context);
    if (const auto albedo = table.find(k.albedo)) mesh.albedo = readBounded(*albedo, context, 1);
    if (const auto color = table.find(k.color)) mesh.color = readBounded(*color, context, 1);
    table.read(k, context.frame, mesh);
    if (mesh.color && !mesh.holdout)
        throw Error(ErrorKind::input,
                    fmt::format("{}: {} shows a mesh that does not hide what is behind it; expected {} = true",
                                table.where(), k.color, k.holdout.name));
    table.finish();
    return mesh;
}

}  // namespace scrim
