// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/shot_study.h>

#include <scrim/base/system_error.h>
#include <scrim/scene/quality.h>
#include <scrim/shot/shot_content.h>

namespace scrim {

ShotStudy::ShotStudy(Shot& shot, int frame, const RenderOptions& options) : m_options(options) {
    m_options.missing = MissingPolicy::error;
    m_loaded = withErrors([&] {
        Shot::Content& content = *shot.m_content;
        Scene scene = withOptions(content.sceneAt(frame, m_options), m_options, *content.stores);
        content.keepPromise(scene, m_options, ShotUse::plan);
        return *loadShot(*content.stores, content.load, std::move(scene), m_options, VolumesOf::scene, ShotUse::plan);
    });
}

ViewScene ShotStudy::viewWith(const Dials& dials, VolumesOf volumesOf) {
    const std::pair key(dials.lod.value_or(0), volumesOf);
    auto found = m_views.find(key);
    if (found == m_views.end()) found = m_views.emplace(key, m_loaded.view(m_options, key.first, volumesOf)).first;
    ViewScene turned = found->second;
    turned.dials = dials;
    turned.layers.clear();  // the study examines the beauty only
    return turned;
}

Study ShotStudy::run(double budget, const ProgressSink& progress) {
    StudyOptions options;
    options.budget = budget;
    options.truth = [this](const Dials& dials) { return viewWith(dials, VolumesOf::scene); };
    options.preset = [this](const std::string& name) {
        return promisedDials(viewWith(*presetDials(name), VolumesOf::picture), name).dials;
    };
    const auto view = [this](const Dials& dials) { return viewWith(dials, VolumesOf::picture); };
    return withErrors([&] { return runStudy(view, m_loaded.scene.dials, options, progress); });
}

}  // namespace scrim
