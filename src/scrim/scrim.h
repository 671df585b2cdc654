// SPDX-License-Identifier: Apache-2.0
// Everything that a program needs to render with Scrim. Start at shot/shot.h.
#pragma once

#include <scrim/base/error.h>
#include <scrim/base/messages.h>
#include <scrim/base/version.h>
#include <scrim/geometry/bounds.h>
#include <scrim/geometry/box2.h>
#include <scrim/geometry/camera.h>
#include <scrim/geometry/spaces.h>
#include <scrim/image/colour.h>
#include <scrim/image/image.h>
#include <scrim/image/texture.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/dials.h>
#include <scrim/scene/frame_path.h>
#include <scrim/scene/light.h>
#include <scrim/scene/medium.h>
#include <scrim/scene/quality.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/scene_lines.h>
#include <scrim/shot/shot.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/shot/shot_options.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/load_options.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_info.h>
