/* Objects and the environment through the C interface: seen, replaced, removed, refused. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "roadgen/capi/roadgen.h"
#include "tests/common/c_expect.h"

enum { kWidth = 96, kHeight = 64 };

/* A straight level road, x from -50 to 50. */
static int write_network(const char* path) {
  FILE* file = fopen(path, "w");
  if (!file) return 0;
  fprintf(file,
          "<OpenDRIVE><header revMajor='1' revMinor='7'/><road name='' length='100' id='main' junction='-1'><planView>"
          "<geometry s='0' x='-50' y='0' hdg='0' length='100'><line/></geometry></planView><elevationProfile/><lanes>"
          "<laneSection s='0'><left><lane id='1' type='driving'><width sOffset='0' a='3.5' b='0' c='0' d='0'/></lane>"
          "</left><center><lane id='0' type='none'/></center><right><lane id='-1' type='driving'><width sOffset='0' "
          "a='3.5' b='0' c='0' d='0'/></lane></right></laneSection></lanes></road></OpenDRIVE>");
  return fclose(file) == 0;
}

static const char* kScene =
    "{\"version\": 1, \"materials\": {\"red\": {\"base_color\": [0.8, 0.02, 0.02], \"roughness\": 1}}, \"objects\": [\n"
    "{\"type\": \"sphere\", \"center\": [0, 0, 1.5], \"radius\": 1, \"material\": \"red\", "
    "\"place\": {\"road\": \"%s\", \"s\": 50}}]}";

static unsigned char color[kWidth * kHeight * 4];
static float depth[kWidth * kHeight];

/* Whether the middle of the picture is red, and how far it is. */
static int sees_red(roadgen_renderer* renderer, float* middle_m) {
  EXPECT(roadgen_render(renderer, kWidth, kHeight, color, depth) == ROADGEN_OK);
  const size_t middle = (kHeight / 2) * kWidth + kWidth / 2;
  *middle_m = depth[middle];
  return color[4 * middle] > 2 * color[4 * middle + 1] && color[4 * middle] > 2 * color[4 * middle + 2];
}

int main(int argc, char** argv) {
  if (argc < 2 || !write_network(argv[1])) return 2;
  roadgen_network* network;
  roadgen_renderer* renderer;
  EXPECT(roadgen_network_load(argv[1], &network) == ROADGEN_OK);
  EXPECT(roadgen_renderer_create(network, NULL, ROADGEN_CONTEXT_OSMESA, &renderer) == ROADGEN_OK);
  if (failures) return 1;
  const roadgen_camera camera = {{-10, 0, 1.5}, 0, 0, 0, 50, 0};
  EXPECT(roadgen_set_camera(renderer, &camera) == ROADGEN_OK);

  float middle_m;
  char text[512];
  EXPECT(!sees_red(renderer, &middle_m));
  snprintf(text, sizeof text, kScene, "main");
  EXPECT(roadgen_set_props(renderer, network, NULL, text) == ROADGEN_OK);
  EXPECT(sees_red(renderer, &middle_m));
  EXPECT(fabs(middle_m - 9) < 0.01);

  /* Refused, and the sphere is still there. */
  EXPECT(roadgen_set_props(renderer, NULL, NULL, text) == ROADGEN_USAGE_ERROR);
  snprintf(text, sizeof text, kScene, "nowhere");
  EXPECT(roadgen_set_props(renderer, network, NULL, text) == ROADGEN_DATA_ERROR);
  EXPECT(strstr(roadgen_last_error(), "props.json:2: objects[0].place: there is no road 'nowhere'") != NULL);
  EXPECT(roadgen_set_props(renderer, network, NULL, "{\"version\": 1, \"objects\": [{\"type\": \"blob\"}]}") ==
         ROADGEN_DATA_ERROR);
  EXPECT(strstr(roadgen_last_error(), "unknown type 'blob'") != NULL);
  EXPECT(roadgen_set_props(renderer, network, "none.json", NULL) == ROADGEN_DATA_ERROR);
  EXPECT(roadgen_set_props(
             renderer, network, "/nowhere/props.json",
             "{\"version\": 1, \"materials\": {\"wood\": {\"texture\": \"wood.png\"}}, "
             "\"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1, \"material\": \"wood\"}]}") ==
         ROADGEN_DATA_ERROR);
  EXPECT(strstr(roadgen_last_error(), "/nowhere/wood.png") != NULL);
  EXPECT(roadgen_set_props(NULL, network, NULL, text) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_set_environment(renderer, "none.exr") == ROADGEN_DATA_ERROR);
  EXPECT(roadgen_set_environment(renderer, "none.png") == ROADGEN_USAGE_ERROR);
  EXPECT(sees_red(renderer, &middle_m));

  /* Removed. */
  EXPECT(roadgen_set_props(renderer, network, NULL, NULL) == ROADGEN_OK);
  EXPECT(!sees_red(renderer, &middle_m));

  roadgen_renderer_free(renderer);
  roadgen_network_free(network);
  return failures ? 1 : 0;
}
