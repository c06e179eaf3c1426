// What objects cost: pixels of the proxies that are rejected; molecules and clouds of spheres against tessellated ones and
// VTK; the paper's Fig. 2, an ellipse magnified a thousand times against a texture of it.
//   build/release/bin/object_bench [--xyzr FILE] [--mesh FILE.obj]
// Every method of a row is measured in turn, again and again, so that what else the machine does meets all alike.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <glm/geometric.hpp>

#include "roadgen/object/object.h"
#include "roadgen/render/gl.h"
#include "roadgen/render/image.h"
#include "roadgen/render/program.h"
#include "roadgen/render/render_target.h"
#include "roadgen/render/renderer.h"
#include "roadgen/render/shader_source.h"
#include "tests/bench/gpu_clock.h"
#include "tests/object_shapes.h"

namespace roadgen::bench {
namespace {

using test::ShapeRandom;

constexpr int kSize = 512;

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "object_bench: %s\n", why.c_str());
  std::exit(1);
}

template <class T>
T need(Result<T> result) {
  if (!result) fail(result.error().text());
  return std::move(*result);
}
void need(const Status& status) {
  if (!status) fail(status.error().text());
}

void use_shaders(const char* folder) {
  if (folder) {
    setenv("ROADGEN_SHADER_DIR", (std::string(ROADGEN_SOURCE_DIR "/tests/bench/shaders") + folder).c_str(), 1);
  } else {
    unsetenv("ROADGEN_SHADER_DIR");
  }
}

// Fragments --------------------------------------------------------------------------------------------------------------

long labelled(Renderer& renderer, const ObjectScene& scene, const ObjectOptions& options, const Camera& camera) {
  need(renderer.load_objects(scene, options));
  const Frame frame = need(renderer.render(camera, {.width = 256, .height = 256, .channels = kLabel}));
  return static_cast<long>(std::count_if(frame.label.pixels.begin(), frame.label.pixels.end(), [](std::uint32_t l) {
    return l == static_cast<std::uint32_t>(Label::kObject);
  }));
}

// Rejected pixels per accepted one, over placements of a shape that fill about half of the picture.
double wasted(Context& context, int kind, const ObjectOptions& options, bool set) {
  Renderer plain = need(Renderer::create(context)), whole = need(Renderer::create(context));
  ShapeRandom random(static_cast<std::uint64_t>(kind) + 1);
  long accepted = 0, drawn = 0;
  for (int i = 0; i < 60; ++i) {
    ObjectScene scene;
    if (set) {
      scene.sphere_sets.emplace_back().items.push_back({{0, 0, 0}, 1});
    } else {
      Object& object = scene.objects.emplace_back();
      object.shape = test::random_shape(kind, random);
      object.transform = glm::dmat4(random.rotation());
    }
    Camera camera;
    camera.position_m = {-random.uniform(3, 8), random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6)};
    accepted += labelled(plain, scene, options, camera);
    use_shaders("/whole");
    drawn += labelled(whole, scene, options, camera);
    use_shaders(nullptr);
  }
  return static_cast<double>(drawn - accepted) / static_cast<double>(accepted);
}

void print_wasted(Context& context) {
  fmt::print(
      "Rejected pixels per accepted pixel, 60 placements each:\n\n| shape | polygon of 4 | 6 | 8 | 12 | 16 | "
      "rectangle |\n|---|---|---|---|---|---|---|\n");
  ShapeRandom random(1);
  const auto row = [&](const std::string& name, int kind, bool set, bool round) {
    std::string text = "| " + name;
    for (const int polygon : {4, 6, 8, 12, 16}) {
      text += fmt::format(" | {:.3f}", wasted(context, kind, {.polygon = polygon}, set));
    }
    text += round ? fmt::format(" | {:.3f} |", wasted(context, kind, {.rectangle = true}, set)) : " | - |";
    fmt::print("{}\n", text);
  };
  row("sphere of a set", 5, true, true);
  for (int kind = 0; kind < test::kShapeKinds; ++kind) {
    row(shape_name(test::random_shape(kind, random)), kind, false, kind == 5 || kind == 6);
  }
}

// Spheres ----------------------------------------------------------------------------------------------------------------

SphereSet read_xyzr(const std::string& path) {
  std::ifstream file(path);
  if (!file) fail("cannot read " + path);
  SphereSet set;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    SphereSet::Item item{{0, 0, 0}, 0, {190, 160, 120, 255}};
    if (words >> item.center.x >> item.center.y >> item.center.z >> item.radius) set.items.push_back(item);
  }
  return set;
}

// As many spheres as the paper's bunny has, spread evenly over the triangles of a mesh.
SphereSet spheres_on(const std::string& path, std::size_t count) {
  std::ifstream file(path);
  if (!file) fail("cannot read " + path);
  std::vector<glm::dvec3> points;
  std::vector<std::array<glm::dvec3, 3>> triangles;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    glm::dvec3 p;
    if (kind == "v" && words >> p.x >> p.y >> p.z) points.push_back(p);
    if (kind != "f") continue;
    std::vector<std::size_t> corners;
    for (std::string corner; words >> corner;) corners.push_back(std::stoul(corner) - 1);
    for (std::size_t i = 2; i < corners.size(); ++i) {
      triangles.push_back({points[corners[0]], points[corners[i - 1]], points[corners[i]]});
    }
  }
  std::vector<double> areas = {0};
  for (const auto& t : triangles) {
    areas.push_back(areas.back() + glm::length(glm::cross(t[1] - t[0], t[2] - t[0])));
  }
  ShapeRandom random(2);
  SphereSet set;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = areas.back() * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const auto& t =
        triangles[static_cast<std::size_t>(std::upper_bound(areas.begin(), areas.end(), at) - areas.begin()) - 1];
    double u = random.uniform(0, 1), v = random.uniform(0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const glm::dvec3 p = t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v;
    set.items.push_back({glm::vec3(100.0 * glm::dvec3(p.z, p.x, p.y)), 0.6f, {190, 160, 120, 255}});
  }
  return set;
}

// Spheres as triangles, each within half a pixel of the sphere seen from the camera: subdivided octahedra, one size a draw.
class Tessellation {
 public:
  Tessellation(const SphereSet& set, const Camera& camera) {
    use_shaders("");
    program_ = need(Program::graphics("ball.vert", "ball.frag"));
    use_shaders(nullptr);
    const double pixel = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / kSize;
    std::array<std::vector<float>, kLevels> instances;
    for (const SphereSet::Item& item : set.items) {
      const glm::dvec3 center = glm::dvec3(item.center) - camera.position_m;
      const double radius_px = item.radius / (std::max(center.x, 1.0) * pixel);
      int level = 0;
      while (level + 1 < kLevels && error(level) * radius_px > 0.5) ++level;
      for (const double x : {center.x, center.y, center.z, static_cast<double>(item.radius)}) {
        instances[static_cast<std::size_t>(level)].push_back(static_cast<float>(x));
      }
    }
    for (int level = 0; level < kLevels; ++level) add(level, instances[static_cast<std::size_t>(level)]);
  }

  // Requires: the uniforms of the renderer's last frame are bound. The target is cleared.
  void draw(const RenderTarget& target) const {
    target.bind();
    const float black[4] = {0, 0, 0, 1}, far[1] = {0};
    glClearBufferfv(GL_COLOR, 0, black);
    glClearBufferfv(GL_DEPTH, 0, far);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glEnable(GL_FRAMEBUFFER_SRGB);
    program_.use();
    for (const Part& part : parts_) {
      glBindVertexArray(part.array.id());
      glVertexAttrib4f(2, 0.745f, 0.627f, 0.47f, 1);
      glDrawArraysInstanced(GL_TRIANGLES, 0, part.vertices, part.count);
    }
    glDisable(GL_CULL_FACE);
    glDisable(GL_FRAMEBUFFER_SRGB);
  }
  std::size_t triangles() const {
    std::size_t sum = 0;
    for (const Part& part : parts_)
      sum += static_cast<std::size_t>(part.vertices / 3) * static_cast<std::size_t>(part.count);
    return sum;
  }

 private:
  static constexpr int kLevels = 6;
  struct Part {
    gl::VertexArray array;
    gl::Buffer corners, instances;
    GLsizei vertices, count;
  };
  // How far the middles of the octahedron's subdivided faces lie within the unit sphere, at most.
  static double error(int level) { return level == 0 ? 0.4227 : 0.4227 / std::pow(3.4, level); }

  static void split(std::vector<glm::vec3>& out, glm::vec3 a, glm::vec3 b, glm::vec3 c, int level) {
    if (level == 0) {
      out.insert(out.end(), {a, b, c});
      return;
    }
    const glm::vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
    split(out, a, ab, ca, level - 1);
    split(out, ab, b, bc, level - 1);
    split(out, ca, bc, c, level - 1);
    split(out, ab, bc, ca, level - 1);
  }

  void add(int level, const std::vector<float>& instances) {
    if (instances.empty()) return;
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) {
      const glm::vec3 x(i & 1 ? -1 : 1, 0, 0), y(0, i & 2 ? -1 : 1, 0), z(0, 0, i & 4 ? -1 : 1);
      const bool odd = ((i & 1) + (i >> 1 & 1) + (i >> 2 & 1)) % 2 == 1;
      split(corners, x, odd ? z : y, odd ? y : z, level);
    }
    Part part;
    part.vertices = static_cast<GLsizei>(corners.size());
    part.count = static_cast<GLsizei>(instances.size() / 4);
    part.corners = gl::Buffer::with_data(static_cast<GLsizeiptr>(corners.size() * sizeof(glm::vec3)), corners.data());
    part.instances = gl::Buffer::with_data(static_cast<GLsizeiptr>(instances.size() * sizeof(float)), instances.data());
    part.array = gl::VertexArray::create();
    const GLuint array = part.array.id();
    glVertexArrayVertexBuffer(array, 0, part.corners.id(), 0, sizeof(glm::vec3));
    glVertexArrayVertexBuffer(array, 1, part.instances.id(), 0, 4 * sizeof(float));
    glVertexArrayBindingDivisor(array, 1, 1);
    for (GLuint i = 0; i < 2; ++i) {
      glEnableVertexArrayAttrib(array, i);
      glVertexArrayAttribFormat(array, i, i == 0 ? 3 : 4, GL_FLOAT, GL_FALSE, 0);
      glVertexArrayAttribBinding(array, i, i);
    }
    parts_.push_back(std::move(part));
  }

  Program program_;
  std::vector<Part> parts_;
};

struct Peer {
  double wall_ms = 0, process_ms = 0, cover = 0;
};

// By the script beside this file; nothing where VTK is not to be had.
std::optional<Peer> vtk(const SphereSet& set, const Camera& camera, int repeats) {
  const std::string path = fmt::format("/tmp/object_bench.{}.xyzr", getpid());
  {
    std::ofstream file(path);
    for (const auto& i : set.items) file << fmt::format("{} {} {} {}\n", i.center.x, i.center.y, i.center.z, i.radius);
  }
  const glm::dvec3 e = camera.position_m;
  const std::string command =
      fmt::format("xvfb-run -a /usr/bin/python3 {}/tests/bench/vtk_spheres.py {} {} {} {} {} {} {} 2>/dev/null",
                  ROADGEN_SOURCE_DIR, path, e.x, e.y, e.z, camera.fov_deg, kSize, repeats);
  Peer peer;
  int found = 0;
  if (FILE* const pipe = popen(command.c_str(), "r")) {
    found = std::fscanf(pipe, "%lf %lf %lf", &peer.wall_ms, &peer.process_ms, &peer.cover);
    pclose(pipe);
  }
  std::remove(path.c_str());
  if (found != 3) return std::nullopt;
  return peer;
}

struct Times {
  std::vector<double> wall, process;
  template <class Draw>
  void add(const Draw& draw) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t spent = std::clock();
    draw();
    process.push_back(1e3 * static_cast<double>(std::clock() - spent) / CLOCKS_PER_SEC);
    wall.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
};

void print_spheres(Context& context, const std::string& name, const SphereSet& set, double distance, int repeats) {
  glm::vec3 low = set.items[0].center, high = low;
  for (const auto& item : set.items) low = glm::min(low, item.center), high = glm::max(high, item.center);
  Camera camera;
  const double radius = 0.5 * glm::length(glm::dvec3(high - low));
  camera.position_m = 0.5 * glm::dvec3(low + high) - glm::dvec3(distance * radius, 0, 0);
  ObjectScene scene;
  scene.sphere_sets.push_back(set);
  // Lit as the peer's are, but for one: Phong, no shadows.
  scene.materials.push_back({.model = ObjectMaterial::Model::kPhong});
  const FrameOptions frame{.width = kSize, .height = kSize, .samples = 1};
  // Without a sky, as the peer.
  use_shaders("/plain");
  constexpr int kWays = 5;
  const ObjectOptions ways[kWays] = {{.shadows = false},
                                     {.rectangle = true, .shadows = false},
                                     {.polygon = 8, .shadows = false},
                                     {.occlusion = false, .shadows = false},
                                     {}};
  std::vector<Renderer> renderers;
  for (const ObjectOptions& way : ways) {
    renderers.push_back(need(Renderer::create(context)));
    need(renderers.back().load_objects(scene, way));
  }
  use_shaders(nullptr);
  const Tessellation mesh(set, camera);
  RenderTarget target = need(RenderTarget::create({kSize, kSize}));
  Times times[kWays + 1];
  const std::optional<Peer> before = vtk(set, camera, repeats);
  for (int i = -1; i < repeats; ++i) {
    // Each method's frame follows one of its own, as the peer's do, and not another's.
    const auto take = [&](int k, const auto& draw) {
      draw();
      Times ignored;
      (i < 0 ? ignored : times[k]).add(draw);
    };
    for (int k = 0; k < kWays; ++k) {
      take(k, [&] { need(renderers[static_cast<std::size_t>(k)].render(camera, frame)); });
    }
    take(kWays, [&] {
      mesh.draw(target);
      static_cast<void>(target.read_rgba8());
    });
  }
  const std::optional<Peer> after = vtk(set, camera, repeats);
  fmt::print("\n{}: {} spheres, eye {} radii away, {} x {} pixels, read back; median of {}\n\n", name, set.items.size(),
             distance, kSize, kSize, repeats);
  fmt::print("| method | process ms | wall ms | process time / VTK's |\n|---|---|---|---|\n");
  const bool peer = before && after;
  const double of_vtk = peer ? 0.5 * (before->process_ms + after->process_ms) : 0;
  const auto row = [&](const std::string& method, double process, double wall) {
    fmt::print("| {} | {:.1f} | {:.1f} | {} |\n", method, process, wall,
               peer ? fmt::format("{:.2f}", process / of_vtk) : "-");
  };
  const std::string names[] = {fmt::format("roadgen ({} drawn)", renderers[0].object_statistics().drawn_spheres),
                               "roadgen, rectangles only",
                               "roadgen, octagons only",
                               "roadgen, hidden ones drawn too",
                               "roadgen, with the sun's shadows",
                               fmt::format("tessellated within half a pixel ({} triangles)", mesh.triangles())};
  for (int k = 0; k <= kWays; ++k) row(names[k], median(times[k].process), median(times[k].wall));
  if (peer) {
    row(fmt::format("VTK's sphere mapper ({:.0f} % covered)", 100 * before->cover), of_vtk,
        0.5 * (before->wall_ms + after->wall_ms));
  } else {
    fmt::print("VTK SKIPPED: python3-vtk9, python3-numpy and xvfb are not all installed\n");
  }
}

void print_clouds(Context& context, const std::string& xyzr, const std::string& mesh, int repeats) {
  const SphereSet molecule = read_xyzr(xyzr), cloud = spheres_on(mesh, 35947);
  for (const double distance : {2.4, 1.25}) print_spheres(context, "Molecule", molecule, distance, repeats);
  for (const double distance : {2.4, 1.6}) print_spheres(context, "Spheres on a mesh", cloud, distance, repeats);
}

// Full screen --------------------------------------------------------------------------------------------------------------

void print_full_screen(Context& context, int repeats) {
  fmt::print(
      "\nOne object over the whole of {} x {} pixels, read back; in 3D and in texture space (the paper's two "
      "acceptances), process ms, and frames per second in 3D\n\n| shape | 3D | texture space | frames/s |\n"
      "|---|---|---|---|\n",
      kSize, kSize);
  const Quadric hyperboloid{{1, 1, -0.5, 0, 0, 0, 0, 0, 0, -0.4}, {-2, -2, -2}, {2, 2, 2}};
  struct Row {
    const char* name;
    Shape shape;
    ObjectMaterial material;
  };
  const ObjectMaterial plain{.name = ""}, glass{.name = "", .roughness = 0, .reflection = 0.2f, .transmission = 0.8f};
  const Row rows[] = {{"sphere", Sphere{{0, 0, 0}, 1}, plain},
                      {"sphere, reflection and refraction", Sphere{{0, 0, 0}, 1}, glass},
                      {"hyperboloid", hyperboloid, plain},
                      {"hyperboloid, reflection", hyperboloid, {.name = "", .roughness = 0, .reflection = 0.5f}},
                      {"torus", Torus{{0, 0, 0}, {1, 0.3, 0.2}, 0.8, 0.5}, plain},
                      {"cylinder", Cylinder{{0, 0, -1.2}, {0, 0, 1.2}, 1}, plain},
                      {"circle", Circle{{0, 0, 0}, {1, 0.1, 0}, 1.3}, plain},
                      {"conic", Conic{{0, 0, 0}, {0, 1.4, 0}, {0, 0, 1.4}, {1, -1, 0, 0, 0, -0.5}}, plain},
                      {"triangle", Triangle{{0, -3, -2}, {0, 3, -2}, {0, 0, 3}}, plain},
                      {"parallelogram", Parallelogram{{0, -1.5, -1.5}, {0, 3, 0}, {0, 0, 3}}, plain}};
  for (const auto& [name, shape, material] : rows) {
    ObjectScene scene;
    scene.objects.push_back({.name = name, .shape = shape});
    scene.materials.push_back(material);
    Camera camera;
    camera.position_m = {-2.2, 0, 0};
    // In turn, so that what else the machine does meets both alike.
    std::array<Renderer, 2> renderers = {need(Renderer::create(context)), need(Renderer::create(context))};
    for (const bool texture : {false, true}) {
      need(renderers[texture].load_objects(scene, {.texture_space = texture, .shadows = false}));
    }
    Times times[2];
    for (int i = -1; i < repeats; ++i) {
      for (const bool texture : {false, true}) {
        Times ignored;
        (i < 0 ? ignored : times[texture]).add([&] {
          need(renderers[texture].render(camera, {.width = kSize, .height = kSize, .samples = 1}));
        });
      }
    }
    fmt::print("| {} | {:.1f} | {:.1f} | {:.0f} |\n", name, median(times[0].process), median(times[1].process),
               1e3 / median(times[0].wall));
  }
}

// Many of a kind -------------------------------------------------------------------------------------------------------------

// Frames of objects of one kind beside and behind one another, about 64 and 12 pixels wide: what proxies cost and spare.
void print_kinds(Context& context, int repeats) {
  fmt::print(
      "\nObjects of one kind over {} x {} pixels, read back, process ms\n\n| shape | 60 large | 2,000 small | 60 "
      "large, "
      "4 samples |\n|---|---|---|---|\n",
      kSize, kSize);
  ShapeRandom names(1);
  for (int kind = 0; kind < test::kShapeKinds; ++kind) {
    std::string row = fmt::format("| {}", shape_name(test::random_shape(kind, names)));
    for (const int column : {0, 1, 2}) {
      const int count = column == 1 ? 2000 : 60;
      const double distance = column == 1 ? 64 : 12;
      ObjectScene scene;
      ShapeRandom random(static_cast<std::uint64_t>(kind) + 3);
      for (int i = 0; i < count; ++i) {
        Object& object = scene.objects.emplace_back();
        object.shape = test::random_shape(kind, random);
        object.transform = glm::dmat4(random.rotation());
        const double x = distance * random.uniform(0.8, 1.2);
        object.transform[3] = glm::dvec4(x, x * random.uniform(-0.5, 0.5), x * random.uniform(-0.5, 0.5), 1);
      }
      Renderer renderer = need(Renderer::create(context));
      need(renderer.load_objects(scene, {.shadows = false}));
      Times times;
      for (int i = -1; i < repeats; ++i) {
        Times ignored;
        (i < 0 ? ignored : times).add([&] {
          need(renderer.render({}, {.width = kSize, .height = kSize, .samples = column == 2 ? 4 : 1}));
        });
      }
      row += fmt::format(" | {:.1f}", median(times.process));
    }
    fmt::print("{} |\n", row);
  }
}

// Conservative depth -----------------------------------------------------------------------------------------------------

// The same scenes with and without the promise that what is written is never nearer than the polygon.
void print_depth(Context& context, const SphereSet& molecule, int repeats) {
  const std::string folder = fmt::format("/tmp/object_bench.{}.shaders", getpid());
  std::filesystem::create_directories(folder);
  for (const char* file : {"spheres.frag", "object.frag"}) {
    std::string text = need(read_shader_file(file));
    text.replace(text.find("layout(depth_less)"), 18, "layout(depth_any) ");
    std::ofstream(folder + "/" + file) << text;
  }
  ObjectScene spheres, quadrics;
  spheres.sphere_sets.push_back(molecule);
  ShapeRandom random(5);
  for (int i = 0; i < 200; ++i) {
    Object& object = quadrics.objects.emplace_back();
    object.shape = Quadric{{1, 1, -0.5, 0, 0, 0, 0, 0, 0, -0.4}};
    object.transform = glm::dmat4(random.rotation());
    object.transform[3] = glm::dvec4(random.uniform(4, 20), random.uniform(-3, 3), random.uniform(-3, 3), 1);
  }
  fmt::print(
      "\nConservative depth, process ms; every sphere drawn, near ones first\n\n"
      "| scene | depth_less | depth_any | ratio |\n|---|---|---|---|\n");
  const auto row = [&](const char* name, const ObjectScene& scene, const Camera& camera) {
    std::vector<Renderer> renderers;
    for (const bool any : {false, true}) {
      if (any) setenv("ROADGEN_SHADER_DIR", folder.c_str(), 1);
      renderers.push_back(need(Renderer::create(context)));
      need(renderers.back().load_objects(scene, {.occlusion = false, .shadows = false}));
      need(renderers.back().render(camera, {.width = kSize, .height = kSize, .samples = 1}));
      use_shaders(nullptr);
    }
    Times times[2];
    for (int i = 0; i < repeats; ++i) {
      for (const std::size_t k : {0, 1}) {
        times[k].add([&] { need(renderers[k].render(camera, {.width = kSize, .height = kSize, .samples = 1})); });
      }
    }
    const double less = median(times[0].process), any = median(times[1].process);
    fmt::print("| {} | {:.1f} | {:.1f} | {:.3f} |\n", name, less, any, less / any);
  };
  glm::vec3 low = molecule.items[0].center, high = low;
  for (const auto& item : molecule.items) low = glm::min(low, item.center), high = glm::max(high, item.center);
  Camera camera;
  row("200 hyperboloids behind one another", quadrics, camera);
  camera.position_m = 0.5 * glm::dvec3(low + high) - glm::dvec3(0.625 * glm::length(glm::dvec3(high - low)), 0, 0);
  row("99,130 spheres", spheres, camera);
  std::filesystem::remove_all(folder);
}

// Fig. 2 -------------------------------------------------------------------------------------------------------------------

// An ellipse that a 512 x 512 picture shows at 400 x 240 pixels, magnified 1,000 times at places of its outline: pixels on the
// wrong side, ours and those of a texture of that picture sampled linearly, and how far off the outline is in pixels.
void print_ellipse(Context& context) {
  constexpr int kPlaces = 24;
  constexpr double kHalfX = 200, kHalfY = 120, kMagnified = 1000;
  // The texture: coverage of each texel by 16 x 16 samples.
  std::vector<double> texture(kSize * kSize);
  const auto inside = [&](double x, double y) { return x * x / (kHalfX * kHalfX) + y * y / (kHalfY * kHalfY) <= 1; };
  for (int i = 0; i < kSize * kSize; ++i) {
    for (int k = 0; k < 256; ++k) {
      texture[static_cast<std::size_t>(i)] +=
          inside(i % kSize + (k % 16 + 0.5) / 16 - kSize / 2, i / kSize + (k / 16 + 0.5) / 16 - kSize / 2) / 256.0;
    }
  }
  const auto sampled = [&](double x, double y) {
    const double u = x + kSize / 2 - 0.5, v = y + kSize / 2 - 0.5;
    const int i = static_cast<int>(std::floor(u)), k = static_cast<int>(std::floor(v));
    const auto at = [&](int a, int b) { return texture[static_cast<std::size_t>(b * kSize + a)]; };
    const double s = u - i, t = v - k;
    return (at(i, k) * (1 - s) + at(i + 1, k) * s) * (1 - t) + (at(i, k + 1) * (1 - s) + at(i + 1, k + 1) * s) * t;
  };
  Renderer renderer = need(Renderer::create(context));
  ObjectScene scene;
  scene.objects.push_back({.name = "ellipse", .shape = Ellipse{{0, 0, 0}, {0, -kHalfX, 0}, {0, 0, kHalfY}}});
  need(renderer.load_objects(scene));
  long ours = 0, theirs = 0;
  for (int place = 0; place < kPlaces; ++place) {
    const double turn = (place + 0.37) * 2 * std::numbers::pi / kPlaces;
    const double cx = kHalfX * std::cos(turn), cy = kHalfY * std::sin(turn);
    // Looking along +x: right is -y. The window is kSize / kMagnified texels wide.
    Camera camera;
    camera.position_m = {-1000, -cx, cy};
    camera.fov_deg = 2 * std::atan(0.5 * kSize / kMagnified / 1000) * 180 / std::numbers::pi;
    const Frame frame = need(renderer.render(camera, {.width = kSize, .height = kSize, .channels = kLabel}));
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double px = cx + (x + 0.5 - kSize / 2) / kMagnified, py = cy - (y + 0.5 - kSize / 2) / kMagnified;
        const bool truth = inside(px, py);
        ours += (frame.label.at(x, y, 0) != 0) != truth;
        theirs += (sampled(px, py) >= 0.5) != truth;
      }
    }
  }
  const double pixels = static_cast<double>(kPlaces) * kSize * kSize, outline = static_cast<double>(kPlaces) * kSize;
  fmt::print(
      "\nAn ellipse magnified 1,000 times, {} windows of {} x {} pixels on its outline:\n\n"
      "| method | wrong pixels of {:.0f} | outline off by, pixels |\n|---|---|---|\n"
      "| roadgen | {} | {:.4f} |\n| 512 x 512 texture, linear | {} | {:.1f} |\n",
      kPlaces, kSize, kSize, pixels, ours, static_cast<double>(ours) / outline, theirs,
      static_cast<double>(theirs) / outline);
}

// Pictures ----------------------------------------------------------------------------------------------------------------

// Every real type of quadric that has area, and every shape, over a floor.
void write_shapes(Context& context, const std::string& path) {
  ObjectScene scene;
  scene.materials.resize(3);
  scene.materials[0].base_color = {0.62f, 0.30f, 0.12f};
  scene.materials[1].base_color = {0.10f, 0.32f, 0.55f};
  scene.materials[2].base_color = {0.30f, 0.32f, 0.28f};
  ShapeRandom random(12);
  const auto add = [&](const Shape& shape, glm::dvec3 at, std::uint32_t material, const glm::dmat3& turn) {
    Object& object = scene.objects.emplace_back();
    object.shape = shape;
    object.material = material;
    object.transform = glm::dmat4(turn);
    object.transform[3] = glm::dvec4(at, 1);
  };
  for (int i = 0; i < 14; ++i) {
    Quadric quadric;
    quadric.coefficients = test::kQuadricFamily[static_cast<std::size_t>(i)];
    const double turn = 0.6;
    const glm::dmat3 about({std::cos(turn), std::sin(turn), 0}, {-std::sin(turn), std::cos(turn), 0}, {0, 0, 1});
    add(quadric, {i / 7 * -3.4, (3 - i % 7) * 2.7, 1.1}, 0, about);
  }
  for (int kind = 0; kind < test::kShapeKinds; ++kind) {
    if (kind == 7) continue;  // a quadric
    const int place = kind > 7 ? kind - 1 : kind;
    add(test::random_shape(kind, random), {-6.8 - place / 6 * 3.2, (2.5 - place % 6) * 2.7, 1.05}, 1, glm::dmat3(1));
  }
  add(Circle{{-4, 0, 0}, {0, 0, 1}, 14}, {0, 0, 0}, 2, glm::dmat3(1));
  Renderer renderer = need(Renderer::create(context));
  need(renderer.load_objects(scene));
  Camera camera;
  camera.position_m = {-16.5, 0, 13};
  camera.pitch_deg = -43;
  camera.fov_deg = 46;
  need(write_png(path, need(renderer.render(camera, {.width = 1280, .height = 720})).color));
}

void write_molecule(Context& context, SphereSet set, const std::string& path) {
  // Colours in layers, so that its parts can be told apart.
  for (SphereSet::Item& item : set.items) {
    const auto band = [&](float x) { return static_cast<std::uint8_t>(150 + 90 * std::sin(x)); };
    item.color = {band(0.03f * item.center.x), band(0.03f * item.center.y + 2), band(0.03f * item.center.z + 4), 255};
  }
  glm::dvec3 low(1e30), high(-1e30);
  for (const auto& item : set.items) {
    low = glm::min(low, glm::dvec3(item.center)), high = glm::max(high, glm::dvec3(item.center));
  }
  ObjectScene scene;
  scene.sphere_sets.push_back(std::move(set));
  scene.materials.emplace_back().base_color = {0.8f, 0.8f, 0.8f};
  Renderer renderer = need(Renderer::create(context));
  need(renderer.load_objects(scene));
  Camera camera;
  camera.position_m = 0.5 * (low + high) - glm::dvec3(1.05 * glm::length(high - low), 0, 0);
  camera.fov_deg = 32;
  need(write_png(path, need(renderer.render(camera, {.width = 960, .height = 600})).color));
}

int run(int argc, char** argv) {
  CLI::App app("What objects cost, and what else would.");
  std::string data = ROADGEN_SOURCE_DIR "/../shared/data/geometry/";
  std::string xyzr = data + "pdb/ribosome_4V5A_first99130.xyzr", mesh = data + "common-3d/spot.obj";
  std::string pictures, parts = "ellipse,spheres,screen,kinds,depth,proxies";
  int repeats = 9;
  app.add_option("--xyzr", xyzr, "spheres, a line x y z radius each")->capture_default_str();
  app.add_option("--mesh", mesh, "a mesh that 35,947 spheres are spread over")->capture_default_str();
  app.add_option("--repeats", repeats, "measurements of each")->capture_default_str();
  app.add_option("--parts", parts, "which tables to make")->capture_default_str();
  app.add_option("--pictures", pictures, "writes PREFIX.shapes.png and PREFIX.molecule.png, and measures nothing");
  CLI11_PARSE(app, argc, argv);
  const std::unique_ptr<Context> context = need(Context::create({.kind = ContextKind::kOsmesa}));
  if (!pictures.empty()) {
    write_shapes(*context, pictures + ".shapes.png");
    write_molecule(*context, read_xyzr(xyzr), pictures + ".molecule.png");
    return 0;
  }
  const auto wanted = [&](const char* part) { return parts.find(part) != std::string::npos; };
  if (wanted("ellipse")) print_ellipse(*context);
  if (wanted("spheres")) print_clouds(*context, xyzr, mesh, repeats);
  if (wanted("screen")) print_full_screen(*context, repeats);
  if (wanted("kinds")) print_kinds(*context, repeats);
  if (wanted("depth")) print_depth(*context, read_xyzr(xyzr), repeats);
  if (wanted("proxies")) print_wasted(*context);
  return 0;
}

}  // namespace
}  // namespace roadgen::bench

int main(int argc, char** argv) { return roadgen::bench::run(argc, argv); }
