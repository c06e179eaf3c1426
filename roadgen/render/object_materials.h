// Internal, not installed: which of the light's parts a program of objects needs.
#pragma once

#include <cstdint>
#include <string>

#include "roadgen/object/object.h"
#include "roadgen/render/shader_source.h"

namespace roadgen {

// MATERIALS of shaders/object_light.glsl for one material of a scene.
inline unsigned material_parts(const ObjectScene& scene, std::uint32_t material) {
  const ObjectMaterial m = scene.materials.empty() ? ObjectMaterial{} : scene.materials[material];
  unsigned parts = m.model == ObjectMaterial::Model::kPhong ? 2 : 1;
  if (!m.texture_file.empty()) parts |= 4;
  if (m.reflection > 0) parts |= 8;
  if (m.transmission > 0) parts |= 16;
  return parts;
}

inline void add_materials(ShaderDefines& defines, unsigned parts) {
  defines.push_back({"MATERIALS", std::to_string(parts)});
}

}  // namespace roadgen
