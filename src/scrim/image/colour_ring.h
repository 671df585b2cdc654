// SPDX-License-Identifier: Apache-2.0
// Finds OpenColorIO configs that refer to themselves: a space whose transform converts to that space, a look that is
// part of itself. OpenColorIO 2.1 follows such a ring until the stack overflows. This is separate from colour.cpp,
// since it has to know what each kind of transform refers to.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <string>

namespace scrim {

/// Throws an OCIO::Exception that names the ring where `conversion` leads into one, or where it leads through so many
/// spaces that following them could overflow the stack. Follows transforms in both directions, as OpenColorIO does when
/// it looks for context variables, so that it refuses nothing that OpenColorIO survives. `name`: that of `config` in
/// messages, "the OpenColorIO config 'a.ocio'".
void refuseRing(const OCIO_NAMESPACE::Config& config, const std::string& name,
                const OCIO_NAMESPACE::ConstTransformRcPtr& conversion);

}  // namespace scrim
