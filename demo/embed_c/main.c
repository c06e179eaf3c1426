/* Embeds roadgen in a C program: loads a network, puts a camera on the road, renders colour and depth into its own
 * memory, and shows that picture and query agree: the depth of the middle pixel, taken back to the world, lies on the
 * road that the query names, at height 0 above it.
 *
 *   embed_c NET.xodr PICTURE.ppm
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <roadgen/capi/roadgen.h>

static const double kDegree = 3.14159265358979323846 / 180;

static int fail(const char* what) {
  fprintf(stderr, "embed_c: %s: %s\n", what, roadgen_last_error());
  return 1;
}

static int write_ppm(const char* path, int width, int height, const uint8_t* rgba) {
  FILE* file = fopen(path, "wb");
  if (!file) return 0;
  fprintf(file, "P6\n%d %d\n255\n", width, height);
  for (int i = 0; i < width * height; ++i) fwrite(rgba + 4 * i, 1, 3, file);
  return fclose(file) == 0;
}

int main(int argc, char** argv) {
  if (argc != 3) {
    fprintf(stderr, "usage: embed_c NET.xodr PICTURE.ppm\n");
    return 2;
  }
  roadgen_network* network = NULL;
  if (roadgen_network_load(argv[1], &network) != ROADGEN_OK) return fail("cannot load the network");
  printf("roadgen %s: %zu road(s), the first is '%s', %.1f m long\n", roadgen_version(), roadgen_road_count(network),
         roadgen_road_id(network, 0), roadgen_road_length_m(network, 0));

  /* Eye height of a driver, in the right lane, looking along the road and a little down. */
  const int64_t road = 0;
  const double s = 0.4 * roadgen_road_length_m(network, 0), t = -1.75;
  roadgen_pose pose;
  if (roadgen_to_world(network, 1, &road, &s, &t, &pose) != ROADGEN_OK) return fail("road to world");
  roadgen_camera camera = {{pose.position_m[0], pose.position_m[1], pose.position_m[2] + 1.3},
                           pose.heading_rad / kDegree,
                           pose.pitch_rad / kDegree - 10,
                           0,
                           50,
                           0};

  roadgen_renderer* renderer = NULL;
  if (roadgen_renderer_create(network, NULL, ROADGEN_CONTEXT_OSMESA, &renderer) != ROADGEN_OK) {
    return fail("cannot make a renderer");
  }
  enum { kWidth = 641, kHeight = 361 };
  uint8_t* color = malloc(4 * kWidth * kHeight);
  float* depth = malloc(sizeof(float) * kWidth * kHeight);
  if (!color || !depth) return 1;
  if (roadgen_set_camera(renderer, &camera) != ROADGEN_OK) return fail("camera");
  if (roadgen_render(renderer, kWidth, kHeight, color, depth) != ROADGEN_OK) return fail("render");
  if (!write_ppm(argv[2], kWidth, kHeight, color)) {
    fprintf(stderr, "embed_c: cannot write %s\n", argv[2]);
    return 1;
  }

  /* The middle pixel looks along the view axis, so its depth is its distance. */
  const double reach = depth[(kHeight / 2) * kWidth + kWidth / 2];
  const double yaw = camera.yaw_deg * kDegree, pitch = camera.pitch_deg * kDegree;
  const double seen[3] = {camera.position_m[0] + reach * cos(pitch) * cos(yaw),
                          camera.position_m[1] + reach * cos(pitch) * sin(yaw),
                          camera.position_m[2] + reach * sin(pitch)};
  roadgen_road_point point;
  if (roadgen_to_road(network, 1, seen, 10, &point) != ROADGEN_OK) return fail("world to road");
  printf("the middle pixel is %.3f m away: road %lld, lane %d, s = %.3f m, t = %.3f m, %.4f m above the surface\n",
         reach, (long long)point.road, point.lane, point.s_m, point.t_m, point.height_m);

  const int agree = point.road == 0 && fabs(point.height_m) < 0.005 && point.distance_m == 0;
  if (!agree) fprintf(stderr, "embed_c: picture and query disagree\n");
  free(color);
  free(depth);
  roadgen_renderer_free(renderer);
  roadgen_network_free(network);
  return agree ? 0 : 1;
}
