// sky_conventions.h — maps in the conventions of other codes brought into ours, and onto our grid.
//
//   zenith    z = z'            or π − z' where z', a' are angles of propagation
//   azimuth   a = zero ± a'     or zero ± a' + π; − where a' is anticlockwise as seen from above
//   light     S1, S2, S3 = s1·S1', s2·S2', s3·S3'
//
// Each is a choice of its own: where another code counts azimuths anticlockwise, that says nothing of
// the sign of its S2. Turning to the opposite meridian or looking along the beam instead of against
// it leaves the axis in the plane of the zenith, and so S1.
//
// Frame   sky.h. Units  rad.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/scene/sky.h"

namespace malus {

enum class AzimuthSense { kClockwise, kAnticlockwise };  ///< as seen from above
enum class AnglesOf { kView, kPropagation };             ///< where one looks, or the light goes

/// How the angles and signs of a map are meant.
struct SkyConventions {
    double azimuth_zero = 0;  ///< our azimuth of what the map calls azimuth 0
    AzimuthSense azimuth_sense = AzimuthSense::kClockwise;
    AnglesOf angles_of = AnglesOf::kView;
    double s1 = 1, s2 = 1, s3 = 1;  ///< factors, +1 or −1
};

/// The same light as we would write it. Node for node, nothing is interpolated; the angles of the
/// map given may lie in [0, π] and in any turn, in any order. Rows below the horizon are left out:
/// the result may have none. The sun's azimuth is taken as one of the map's, of view.
Sky in_our_conventions(const Sky& map, const SkyConventions& conventions);

/// The map of azimuths 0 to π, and its mirror image about the plane of azimuth 0: S0 and S1 even, S2
/// and S3 odd, as of any sky about its sun. Azimuths must lie in [0, π].
Sky with_mirror_image(const Sky& half);

/// Rows and columns of a picture of the dome.
struct MapSize {
    int zeniths = 0, azimuths = 0;
};

/// As fine as the map's nodes where they are evenly spaced all around, else 1°.
MapSize grid_like(const Sky& map);

/// The map at pixel centres of such a picture: the same nodes where they stand there already, else
/// interpolated as SkyDome does, which breaks neither at the zenith nor at the seam.
Sky at_pixel_centres(const Sky& map, const MapSize& grid);

}  // namespace malus
