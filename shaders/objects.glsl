// What the stages of objects share: the view in double, instances, materials; and the primitives' files.
#include "lib/object.glsl"
#include "lib/sphere.glsl"
#include "lib/quadric.glsl"
#include "lib/cone.glsl"
#include "lib/polyhedron.glsl"
#include "lib/torus.glsl"
#include "lib/planar.glsl"

// Places are taken in double once a vertex, so that a sphere 1e5 radii away, magnified, is as exact as a near one.
layout(std140, binding = 1) uniform ObjectView {
  dvec4 view_right;    // unit axes; w: the eye, ENU, m: x
  dvec4 view_up;       // y
  dvec4 view_forward;  // z
  dvec4 view_size;     // half the picture's size in pixels, x and y; a pixel's size at distance 1, and its inverse
};

// As roadgen/render/object_batch.cc writes it.
struct ObjectInstance {
  dvec4 center;      // world, m; w: radius of a ball around it, m
  dvec4 inverse[3];  // rows of the shape's frame from the world; w: 0
  vec4 axes[3];      // columns of the world from the shape's frame; w: of 0 the instance's number, of 1 the material's, as bits
  vec4 numbers[3];   // p0 to p9, flags
};

ObjectShape object_shape(ObjectInstance i) {
  return ObjectShape(i.numbers[0].x, i.numbers[0].y, i.numbers[0].z, i.numbers[0].w, i.numbers[1].x, i.numbers[1].y,
                     i.numbers[1].z, i.numbers[1].w, i.numbers[2].x, i.numbers[2].y, int(i.numbers[2].z));
}

struct ObjectMaterial {
  vec4 base;      // linear colour; w: 0 metal and roughness, 1 Phong
  vec4 surface;   // metallic, roughness, reflection, transmission
  vec4 specular;  // colour; w: shininess
  vec4 more;      // index of refraction; 1 + layer of the texture, 0: none
};
layout(std430, binding = 6) readonly buffer ObjectMaterials { ObjectMaterial object_materials[]; };

vec3 object_in_view(dvec3 p) {
  return vec3(dot(view_right.xyz, p), dot(view_up.xyz, p), dot(view_forward.xyz, p));
}
