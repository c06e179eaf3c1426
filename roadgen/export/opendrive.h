// The network as an OpenDRIVE 1.7 file (ASAM OpenDRIVE 1.7.0, 2021).
//
// A segment is one <geometry> with one <paramPoly3 pRange="normalized">: the chord-frame cubic of the road function,
// turned into the frame of its start tangent, so aU = aV = bV = 0 and bU > 0; its length is the true arc length
// (clause 9.3). Elevation and superelevation are one record per segment (clause 10.5); crossfall is a <shape> of two
// straight pieces where segments start. Every lane section is one <laneSection>, with one record of everything (clause
// 11); its lanes are linked to those that hold their middle in the sections beside it. Paint is an <object> of type
// roadMark or crosswalk (clause 13).
// A closed road is its own predecessor and successor.
//
// Georeference. A network in a projection has it in <geoReference> and its offset in <offset>. Others live in topocentric
// ENU about an origin. OpenDRIVE wants a PROJ string of a projected system in <geoReference>; the one that is topocentric ENU, exactly so for points of the ellipsoid's surface, is the
// ellipsoidal orthographic projection (EPSG method 9840, PROJ 7.2 or later). At height h a position differs from it by
// h / 6.38e6 of its distance from the origin (0.16 mm per metre and km of height). The origin itself, with its height,
// stands in <userData code="roadgen:origin" value="LAT LON H"/>.
//
// Numbers are written with as many digits as bring the same double back (17 at most). The anchors and slopes cannot be
// recovered bit for bit from rounded polynomial coefficients, so they stand beside them in
// <userData code="roadgen:chord" value="END_X END_Y SLOPE_START SLOPE_END"/>; likewise "roadgen:crossfall" (S and the
// coefficients left and right), "roadgen:mark" (WIDTH SPACE ON OFF PHASE), "roadgen:paint" (COLOUR STRIPE), "roadgen:sweep"
// (xodr_objects.cc), "roadgen:joined" (START END), "roadgen:area", "roadgen:arm", "roadgen:junction" and "roadgen:link"
// (xodr_junctions.h); thus a network that was written, read and written again is the same file. Where a junction's area
// has no connections of its own, the file gets connecting roads for the movements() between its arms; "roadgen:derived"
// marks them, and they are left out when the file is read, since they follow from the area. Other programs skip userData
// and lose nothing.
#pragma once

#include <string>

#include "roadgen/road/network.h"

namespace roadgen {

// The text of the file. Cost: O(segments).
// Errors: kData where a road has no segments or no lane sections, an id is empty or used twice, a number is not finite,
// or a junction's corners are not those that make_junction lays for its arms and radius.
Result<std::string> opendrive_text(const Network& network);

// Writes the text to path, whole or not at all, and without ever having all of it in memory. Errors: as opendrive_text; kIo.
Status write_opendrive(const Network& network, const std::string& path);

}  // namespace roadgen
