// Point clouds and molecules as sets of spheres: .pdb, .xyzr and .ply.
//
//   .pdb   one sphere per ATOM and HETATM record of the first model, of every alternate location the first. Radii and
//          colours by element; angstroms are read as metres. Source: wwPDB, Atomic Coordinate Entry Format 3.3
//   .xyzr  lines "x y z radius [element]"; blank lines and those that start with '#' are skipped. Colours by element
//   .ply   one sphere per vertex: properties x, y, z and, where there are, radius and red, green, blue (0 to 255, or 0 to
//          1 in float). ascii 1.0 and binary_little_endian 1.0. Source: G. Turk, The PLY Polygon File Format, 1994
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "roadgen/object/object.h"
#include "roadgen/road/result.h"

namespace roadgen {

struct PointCloudOptions {
  // Of spheres to which the file gives none, > 0. Default: 0, such a file is an error. A .pdb always gives one.
  double radius = 0;
};

// What of an element is drawn. Radii are van der Waals': A. Bondi 1964, main-group elements that it lacks by M. Mantina et
// al. 2009. Colours are those of R. Corey, L. Pauling and W. Koltun's models as the program Jmol has extended them to all
// elements. symbol: in any case; what is not known has radius 2 and is pink.
struct Element {
  float radius = 2;  // angstrom
  std::array<std::uint8_t, 4> color{255, 20, 147, 255};
};
Element element(std::string_view symbol);

// By the file's ending. The set's origin is the middle of the points' box, its material 0, its name the file's.
// Errors: kIo; kUsage for another ending; kParse with the line: a cell that is not a number, a missing cell, a header
// that is not the format's, fewer vertices than it says; kData: a coordinate that is not finite, a radius that is not
// greater than 0, no point at all, more than kMostPoints. Memory: 20 bytes a sphere beside the file itself.
Result<SphereSet> read_point_cloud(const std::string& path, const PointCloudOptions& options = {});

// Likewise from the bytes of a file; `file`: its name, which tells the format, and which errors have.
Result<SphereSet> parse_point_cloud(std::string_view bytes, const std::string& file,
                                    const PointCloudOptions& options = {});

inline constexpr std::size_t kMostPoints = 50'000'000;

}  // namespace roadgen
