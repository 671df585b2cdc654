// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/colour_ring.h>

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

namespace scrim {
namespace {

/// OpenColorIO's stack frames for a thousand spaces take less than 3 MB, and threads have 4 MB or more.
constexpr std::size_t kMostParts = 1000;

/// The names in "a, +b : -c | d". A name may hold a ':' where the list has commas.
std::vector<std::string> looksIn(std::string_view text) {
    std::vector<std::string> names;
    while (!text.empty()) {
        const std::string_view option = text.substr(0, text.find('|'));
        text.remove_prefix(std::min(text.size(), option.size() + 1));
        const char separator = option.find(',') == option.npos ? ':' : ',';
        for (std::size_t at = 0; at <= option.size();) {
            const std::size_t end = std::min(option.find(separator, at), option.size());
            const std::string_view token = option.substr(at, end - at);
            at = end + 1;
            const std::size_t first = token.find_first_not_of(" \t+-"), last = token.find_last_not_of(" \t");
            if (first != token.npos) names.emplace_back(token.substr(first, last + 1 - first));
        }
    }
    return names;
}

class Walk {
  public:
    Walk(const OCIO::Config& config, const std::string& name) : m_config(config), m_name(name) {}

    void through(const OCIO::ConstTransformRcPtr& transform);

  private:
    /// The kinds of reference space between which a transform converts.
    using References = std::set<OCIO::ReferenceSpaceType>;

    /// Calls `inside` where the part of the config that is called `part` was not walked before.
    template <typename Inside>
    void enter(const std::string& part, const Inside& inside);
    void space(const std::string& name, References& references);
    void looks(const char* names, bool converts, References& references);
    void view(const std::string& display, const char* view, References& references);
    void betweenReferences(const References& references);
    void viewTransform(const OCIO::ConstViewTransformRcPtr& transform);

    [[noreturn]] void fail(const std::string& problem) const;

    const OCIO::Config& m_config;
    const std::string& m_name;
    std::vector<std::string> m_path;  // the parts that led here
    std::set<std::string> m_walked;
};

void Walk::fail(const std::string& problem) const {
    throw OCIO::Exception(fmt::format("in {} {}", m_name, problem).c_str());
}

template <typename Inside>
void Walk::enter(const std::string& part, const Inside& inside) {
    if (m_walked.contains(part)) return;
    if (const auto ring = std::find(m_path.begin(), m_path.end(), part); ring != m_path.end())
        fail(fmt::format("{} refers to itself{}{}", part, m_path.end() - ring > 1 ? " by way of " : "",
                         fmt::join(ring + 1, m_path.end(), ", ")));
    if (m_path.size() == kMostParts)
        fail(fmt::format("{} leads through more than {} spaces and looks", m_path.front(), kMostParts));
    m_path.push_back(part);
    inside();
    m_path.pop_back();
    m_walked.insert(part);
}

void Walk::through(const OCIO::ConstTransformRcPtr& transform) {
    References references;
    if (const auto group = OCIO::DynamicPtrCast<const OCIO::GroupTransform>(transform)) {
        for (int i = 0; i < group->getNumTransforms(); ++i) through(group->getTransform(i));
    } else if (const auto spaces = OCIO::DynamicPtrCast<const OCIO::ColorSpaceTransform>(transform)) {
        space(spaces->getSrc(), references);
        space(spaces->getDst(), references);
    } else if (const auto looked = OCIO::DynamicPtrCast<const OCIO::LookTransform>(transform)) {
        space(looked->getSrc(), references);
        space(looked->getDst(), references);
        looks(looked->getLooks(), !looked->getSkipColorSpaceConversion(), references);
    } else if (const auto shown = OCIO::DynamicPtrCast<const OCIO::DisplayViewTransform>(transform)) {
        space(shown->getSrc(), references);
        view(shown->getDisplay(), shown->getView(), references);
    }
    betweenReferences(references);
}

void Walk::space(const std::string& name, References& references) {
    const char* const resolved = m_config.getCurrentContext()->resolveStringVar(name.c_str());
    if (const OCIO::ConstColorSpaceRcPtr found = m_config.getColorSpace(resolved)) {
        references.insert(found->getReferenceSpaceType());
        enter(fmt::format("the colour space '{}'", found->getName()), [&] {
            through(found->getTransform(OCIO::COLORSPACE_DIR_TO_REFERENCE));
            through(found->getTransform(OCIO::COLORSPACE_DIR_FROM_REFERENCE));
        });
    } else if (const OCIO::ConstNamedTransformRcPtr named = m_config.getNamedTransform(resolved)) {
        enter(fmt::format("the named transform '{}'", named->getName()), [&] {
            through(named->getTransform(OCIO::TRANSFORM_DIR_FORWARD));
            through(named->getTransform(OCIO::TRANSFORM_DIR_INVERSE));
        });
    }
}

void Walk::looks(const char* names, bool converts, References& references) {
    for (const std::string& name : looksIn(names)) {
        const OCIO::ConstLookRcPtr look = m_config.getLook(name.c_str());
        if (!look) continue;
        enter(fmt::format("the look '{}'", look->getName()), [&] {
            through(look->getTransform());
            through(look->getInverseTransform());
        });
        if (converts) space(look->getProcessSpace(), references);
    }
}

void Walk::view(const std::string& display, const char* view, References& references) {
    const std::string shown = m_config.getDisplayViewColorSpaceName(display.c_str(), view);
    References ofDisplay;
    space(shown == OCIO::OCIO_VIEW_USE_DISPLAY_NAME ? display : shown, ofDisplay);
    looks(m_config.getDisplayViewLooks(display.c_str(), view), true, references);
    const auto found = m_config.getViewTransform(m_config.getDisplayViewTransformName(display.c_str(), view));
    if (!found) return references.merge(ofDisplay);
    references.insert(found->getReferenceSpaceType());  // from there it leads to the display's reference itself
    viewTransform(found);
}

/// Conversions between scene and display go through the config's first view transform.
void Walk::betweenReferences(const References& references) {
    if (references.size() > 1) viewTransform(m_config.getDefaultSceneToDisplayViewTransform());
}

void Walk::viewTransform(const OCIO::ConstViewTransformRcPtr& transform) {
    if (!transform) return;
    enter(fmt::format("the view transform '{}'", transform->getName()), [&] {
        through(transform->getTransform(OCIO::VIEWTRANSFORM_DIR_TO_REFERENCE));
        through(transform->getTransform(OCIO::VIEWTRANSFORM_DIR_FROM_REFERENCE));
    });
}

}  // namespace

void refuseRing(const OCIO::Config& config, const std::string& name, const OCIO::ConstTransformRcPtr& conversion) {
    Walk(config, name).through(conversion);
}

}  // namespace scrim
