#include "roadgen/render/environment.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/program.h"
#include "shaders/lib/glsl.h"

namespace roadgen {
namespace {

using Lib = glsl::Library<double>;
using std::numbers::pi;

// Texels along a face: of a panorama of 1,024 x 512 about all there is; the sky is smooth.
constexpr int kPanoramaSize = 256, kSkySize = 64;
constexpr int kLeastSize = 4;  // of the last level
constexpr int kTableSize = 32;

// The uniform block of shaders/environment.glsl.
struct EnvironmentLight {
  glm::vec4 harmonics[9];
  glm::vec4 cube;  // levels - 1
};

int level_count(int size) { return std::bit_width(static_cast<unsigned>(size / kLeastSize)); }

gl::Texture make_cube(int size, int levels) {
  gl::Texture cube = gl::Texture::create(GL_TEXTURE_CUBE_MAP);
  glTextureStorage2D(cube.id(), levels, GL_RGBA16F, size, size);
  glTextureParameteri(cube.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(cube.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return cube;
}

// Runs the program over one level. Requires: its uniforms and textures set.
void fill(const Program& program, const gl::Texture& cube, int level, int size) {
  program.use();
  glBindImageTexture(0, cube.id(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA16F);
  const auto groups = static_cast<GLuint>((size + 7) / 8);
  glDispatchCompute(groups, groups, 6);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
  glUseProgram(0);
}

gl::Texture make_table() {
  std::vector<glm::vec2> values;
  for (int row = 0; row < kTableSize; ++row) {
    for (int column = 0; column < kTableSize; ++column) {
      values.emplace_back(split_sum((column + 0.5) / kTableSize, (row + 0.5) / kTableSize));
    }
  }
  gl::Texture table = gl::Texture::image_2d(GL_RG16F, kTableSize, kTableSize);
  glTextureSubImage2D(table.id(), 0, 0, 0, kTableSize, kTableSize, GL_RG, GL_FLOAT, values.data());
  glTextureParameteri(table.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(table.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(table.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(table.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return table;
}

}  // namespace

Harmonics harmonics_of(const ImageF& panorama) {
  Harmonics sum{};
  for (int y = 0; y < panorama.height; ++y) {
    const double polar = (y + 0.5) / panorama.height * pi;
    const double angle = std::sin(polar) * (pi / panorama.height) * (2 * pi / panorama.width);
    for (int x = 0; x < panorama.width; ++x) {
      const double turn = (0.5 - (x + 0.5) / panorama.width) * 2 * pi;
      const glm::dvec3 d(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
      const glm::dvec3 light(panorama.at(x, y, 0), panorama.at(x, y, 1), panorama.at(x, y, 2));
      for (int i = 0; i < 9; ++i) sum[static_cast<std::size_t>(i)] += light * (angle * Lib::light_harmonic(i, d));
    }
  }
  for (int i = 0; i < 9; ++i) sum[static_cast<std::size_t>(i)] *= Lib::light_harmonic_cosine(i);
  return sum;
}

Harmonics harmonics_of_sky() {
  // Its light is linear in the normal's z: two harmonics.
  const glm::dvec3 up = Lib::sky_ambient(1.0), down = Lib::sky_ambient(-1.0), top(0, 0, 1);
  Harmonics sum{};
  sum[0] = 0.5 * (up + down) / Lib::light_harmonic(0, top);
  sum[2] = 0.5 * (up - down) / Lib::light_harmonic(2, top);
  return sum;
}

glm::dvec2 split_sum(double cosine, double roughness) {
  constexpr int kRings = 32, kTurns = 16;
  const double alpha = std::max(roughness * roughness, 1e-4);
  const glm::dvec3 v(std::sqrt(1 - cosine * cosine), 0, cosine);
  glm::dvec2 sum(0);
  for (int ring = 0; ring < kRings; ++ring) {
    // Denser toward the lobe's rim, whose few microfacets send much to a grazing eye.
    const double left = 1 - (ring + 0.5) / kRings;
    for (int turn = 0; turn < kTurns; ++turn) {
      const glm::dvec3 h = Lib::light_half_vector(1 - std::pow(left, 4), 0.5 * (turn + 0.5) / kTurns, alpha);
      const double vh = glm::dot(v, h), nl = 2 * vh * h.z - v.z;
      if (!(vh > 0 && nl > 0)) continue;
      const double part = 16 * std::pow(left, 3) * Lib::light_visibility(nl, cosine, alpha) * nl * vh / h.z;
      const double fresnel = std::pow(1 - vh, 5);
      sum += part * glm::dvec2(1 - fresnel, fresnel);
    }
  }
  return sum / static_cast<double>(kRings * kTurns);
}

Status Environment::filter(gl::Texture source, const Harmonics& harmonics) {
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  levels_ = level_count(size_);
  glGenerateTextureMipmap(source.id());
  cube_ = make_cube(size_, levels_);
  glCopyImageSubData(source.id(), GL_TEXTURE_CUBE_MAP, 0, 0, 0, 0, cube_.id(), GL_TEXTURE_CUBE_MAP, 0, 0, 0, 0, size_,
                     size_, 6);
  auto program = Program::compute("environment.comp", {{"FILTER", ""}});
  if (!program) return program.error();
  glBindTextureUnit(0, source.id());
  for (int level = 1; level < levels_; ++level) {
    const double roughness = static_cast<double>(level) / (levels_ - 1);
    const int samples = 64 << std::min(2 * (level - 1), 4);
    glProgramUniform1f(program->id(), 0, static_cast<float>(roughness * roughness));
    glProgramUniform1i(program->id(), 1, samples);
    glProgramUniform1f(program->id(), 2, 4.0f / static_cast<float>(size_ * size_));
    fill(*program, cube_, level, size_ >> level);
  }
  table_ = make_table();
  EnvironmentLight light;
  for (std::size_t i = 0; i < 9; ++i) light.harmonics[i] = glm::vec4(harmonics[i], 0);
  light.cube = glm::vec4(static_cast<float>(levels_ - 1), 0, 0, 0);
  light_ = gl::Buffer::with_data(sizeof light, &light);
  return Done{};
}

Result<Environment> Environment::of_sky(glm::vec3 toward_sun) {
  auto program = Program::compute("environment.comp", {{"FROM_SKY", ""}});
  if (!program) return program.error();
  Environment made;
  made.size_ = kSkySize;
  gl::Texture source = make_cube(kSkySize, level_count(kSkySize));
  glProgramUniform3f(program->id(), 0, toward_sun.x, toward_sun.y, toward_sun.z);
  fill(*program, source, 0, kSkySize);
  if (Status s = made.filter(std::move(source), harmonics_of_sky()); !s) return s.error();
  return made;
}

Result<Environment> Environment::of_panorama(const ImageF& panorama) {
  auto program = Program::compute("environment.comp", {{"FROM_PANORAMA", ""}});
  if (!program) return program.error();
  const int levels = std::bit_width(static_cast<unsigned>(panorama.width));
  gl::Texture image = gl::Texture::image_2d(GL_RGB16F, panorama.width, panorama.height, levels);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(image.id(), 0, 0, 0, panorama.width, panorama.height, GL_RGB, GL_FLOAT, panorama.pixels.data());
  glGenerateTextureMipmap(image.id());
  glTextureParameteri(image.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(image.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(image.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTextureParameteri(image.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  Environment made;
  made.size_ = kPanoramaSize;
  gl::Texture source = make_cube(kPanoramaSize, level_count(kPanoramaSize));
  glBindTextureUnit(0, image.id());
  fill(*program, source, 0, kPanoramaSize);
  if (Status s = made.filter(std::move(source), harmonics_of(panorama)); !s) return s.error();
  return made;
}

void Environment::bind() const {
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  glBindTextureUnit(6, cube_.id());
  glBindTextureUnit(7, table_.id());
  glBindBufferBase(GL_UNIFORM_BUFFER, 2, light_.id());
}

}  // namespace roadgen
