// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/held_ray.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scrim {

HeldRay::HeldRay(const DepthPicture* picture, double x, double y, double perDepth) {
    if (picture == nullptr) return;
    m_pieces = picture->at(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
    if (!picture->alongRay) m_scale = perDepth;
}

double HeldRay::end() const {
    for (const DepthPicture::Piece& piece : m_pieces)
        if (std::isinf(piece.tau)) return piece.begin * m_scale;
    return std::numeric_limits<double>::infinity();
}

double HeldRay::transmittance(double distance) const {
    double left = 1;
    for (const DepthPicture::Piece& piece : m_pieces) {
        const double begin = piece.begin * m_scale, end = piece.end * m_scale;
        if (distance <= begin) break;
        const double part = end > begin ? std::min(1.0, (distance - begin) / (end - begin)) : 1;
        left *= std::exp(-part * double(piece.tau));
    }
    return left;
}

double HeldRay::limited(double distance, double step, double mostTau) const {
    for (const DepthPicture::Piece& piece : m_pieces) {
        const double begin = piece.begin * m_scale, end = piece.end * m_scale;
        for (const double change : {begin, end})
            if (change > distance) step = std::min(step, change - distance);
        if (end > begin && begin <= distance && distance < end)
            step = std::min(step, mostTau * (end - begin) / double(piece.tau));
    }
    return step;
}

}  // namespace scrim
