/* The queries of the C interface, from C: known answers, there and back, hints, candidates, threads, errors. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "roadgen/capi/roadgen.h"
#include "tests/common/c_expect.h"

#define EXPECT_NEAR(a, b, tolerance) EXPECT(fabs((a) - (b)) <= (tolerance))

static const char* kRoad =
    "<road name='' length='100' id='%s' junction='-1'><planView><geometry s='0' x='-50' y='%g' hdg='0' length='100'>"
    "<arc curvature='%g'/></geometry></planView><elevationProfile><elevation s='0' a='%g' b='%g' c='0' d='0'/>"
    "</elevationProfile><lanes><laneSection s='0'><left><lane id='1' type='driving'><width sOffset='0' a='3.5' b='0' "
    "c='0' d='0'/></lane></left><center><lane id='0' type='none'/></center><right><lane id='-1' type='driving'><width "
    "sOffset='0' a='3.5' b='0' c='0' d='0'/></lane></right></laneSection></lanes></road>";

/* Two straight roads above one another, y = 0 climbing by 1 in 10 and y = 2 at a height of 20 m; and an arc of 100 m
 * radius from (-50, 200). */
static int write_network(const char* path) {
  FILE* file = fopen(path, "w");
  if (!file) return 0;
  fprintf(file, "<OpenDRIVE><header revMajor='1' revMinor='7'/>");
  fprintf(file, kRoad, "low", 0.0, 1e-9, 0.0, 0.1);
  fprintf(file, kRoad, "bridge", 2.0, 1e-9, 20.0, 0.0);
  fprintf(file, kRoad, "arc", 200.0, 0.01, 5.0, 0.0);
  fprintf(file, "</OpenDRIVE>");
  return fclose(file) == 0;
}

static void known_answers(const roadgen_network* network) {
  EXPECT(roadgen_road_count(network) == 3);
  const double nan_ = NAN;
  const double xyz[] = {-20, 1, 3.5, -20, 1, 19, 0, -5, 5, 0, 90, 0, nan_, 0, 0};
  roadgen_road_point points[5];
  EXPECT(roadgen_to_road(network, 5, xyz, 10, points) == ROADGEN_OK);
  EXPECT(points[0].road == 0 && points[0].junction == -1 && points[0].lane == 1);
  EXPECT_NEAR(points[0].s_m, 30, 1e-5); /* the line is an arc of 10^9 m */
  EXPECT_NEAR(points[0].t_m, 1, 1e-5);
  EXPECT_NEAR(points[0].height_m, 0.5, 1e-5);
  EXPECT(points[0].distance_m == 0);
  EXPECT(points[1].road == 1 && points[1].lane == -1);
  EXPECT_NEAR(points[1].height_m, -1, 1e-9);
  EXPECT(points[2].road == 0 && points[2].lane == 0);
  EXPECT_NEAR(points[2].distance_m, 1.5, 1e-5);
  EXPECT(points[3].road == -1 && points[3].junction == -1);
  EXPECT(points[4].road == -1);

  const int64_t road[] = {0, 1, 2};
  const double s[] = {30, 100, 25}, t[] = {1, -3, 2};
  roadgen_pose poses[3];
  EXPECT(roadgen_to_world(network, 3, road, s, t, poses) == ROADGEN_OK);
  EXPECT_NEAR(poses[0].position_m[0], -20, 1e-5);
  EXPECT_NEAR(poses[0].position_m[2], 3, 1e-9);
  EXPECT_NEAR(poses[0].grade, 0.1, 1e-9);
  EXPECT_NEAR(poses[0].pitch_rad, atan(0.1), 1e-9);
  EXPECT_NEAR(poses[0].normal[0], -0.1 / sqrt(1.01), 1e-9);
  EXPECT_NEAR(poses[0].normal[2], 1 / sqrt(1.01), 1e-9);
  EXPECT_NEAR(poses[1].position_m[1], -1, 1e-5);
  EXPECT_NEAR(poses[2].heading_rad, 0.25, 1e-3); /* segments are within 1 mm of the arc */
  EXPECT_NEAR(poses[2].curvature_per_m, 0.01, 1e-3);
  EXPECT_NEAR(poses[2].position_m[0], -50 + 98 * sin(0.25), 2e-3);
  EXPECT_NEAR(poses[2].position_m[1], 300 - 98 * cos(0.25), 2e-3);
}

static double part(unsigned* state) {
  *state = *state * 1664525u + 1013904223u;
  return *state / 4294967296.0;
}

enum { kPoints = 20000, kThreads = 4 };

struct Task {
  const roadgen_network* network;
  double *s, *t, *xyz;
  int64_t* road;
  roadgen_pose* poses;
  roadgen_road_point* points;
};

/* Random places to the world and back, in one call each. */
static void* there_and_back(void* argument) {
  struct Task* task = argument;
  roadgen_to_world(task->network, kPoints, task->road, task->s, task->t, task->poses);
  for (int i = 0; i < kPoints; ++i) memcpy(task->xyz + 3 * i, task->poses[i].position_m, 3 * sizeof(double));
  roadgen_to_road(task->network, kPoints, task->xyz, 1, task->points);
  return NULL;
}

static void threads_agree_and_places_come_back(const roadgen_network* network) {
  struct Task tasks[kThreads];
  pthread_t threads[kThreads];
  for (int k = 0; k < kThreads; ++k) {
    struct Task* task = &tasks[k];
    task->network = network;
    task->s = malloc(kPoints * sizeof(double));
    task->t = malloc(kPoints * sizeof(double));
    task->road = malloc(kPoints * sizeof(int64_t));
    task->xyz = malloc(3 * kPoints * sizeof(double));
    task->poses = calloc(kPoints, sizeof(roadgen_pose));
    task->points = calloc(kPoints, sizeof(roadgen_road_point));
    if (!task->s || !task->t || !task->road || !task->xyz || !task->poses || !task->points) exit(1);
    unsigned state = 7;
    for (int i = 0; i < kPoints; ++i) {
      task->road[i] = i % 3;
      task->s[i] = 100 * part(&state);
      task->t[i] = 7 * part(&state) - 3.5;
    }
  }
  for (int k = 0; k < kThreads; ++k) pthread_create(&threads[k], NULL, there_and_back, &tasks[k]);
  for (int k = 0; k < kThreads; ++k) pthread_join(threads[k], NULL);
  for (int i = 0; i < kPoints && failures == 0; ++i) {
    EXPECT(tasks[0].points[i].road == tasks[0].road[i]);
    EXPECT_NEAR(tasks[0].points[i].s_m, tasks[0].s[i], 1e-6);
    EXPECT_NEAR(tasks[0].points[i].t_m, tasks[0].t[i], 1e-6);
    EXPECT_NEAR(tasks[0].points[i].height_m, 0, 1e-6);
  }
  for (int k = 0; k < kThreads; ++k) {
    EXPECT(memcmp(tasks[k].poses, tasks[0].poses, kPoints * sizeof(roadgen_pose)) == 0);
    for (int i = 0; i < kPoints; ++i) {
      const roadgen_road_point a = tasks[k].points[i], b = tasks[0].points[i];
      EXPECT(a.road == b.road && a.s_m == b.s_m && a.t_m == b.t_m && a.lane == b.lane && a.height_m == b.height_m);
    }
  }
  for (int k = 0; k < kThreads; ++k) {
    free(tasks[k].s), free(tasks[k].t), free(tasks[k].road), free(tasks[k].xyz);
    free(tasks[k].poses), free(tasks[k].points);
  }
}

/* Four wheels along the arc: hints change nothing, and the pose is the contact's. */
static void wheels_with_a_hint(const roadgen_network* network) {
  roadgen_hint hint = ROADGEN_HINT_NONE;
  for (int step = 0; step < 400; ++step) {
    const int64_t road = 2;
    const double s = 0.24 * step, t = 1;
    roadgen_pose at;
    EXPECT(roadgen_to_world(network, 1, &road, &s, &t, &at) == ROADGEN_OK);
    double wheels[12];
    for (int k = 0; k < 4; ++k) {
      const double ahead = k < 2 ? 1.3 : -1.3, left = k % 2 ? -0.8 : 0.8;
      wheels[3 * k] = at.position_m[0] + ahead * cos(at.heading_rad) - left * sin(at.heading_rad);
      wheels[3 * k + 1] = at.position_m[1] + ahead * sin(at.heading_rad) + left * cos(at.heading_rad);
      wheels[3 * k + 2] = at.position_m[2] + 0.3;
    }
    roadgen_road_point cold[4], warm[4];
    roadgen_pose poses[4];
    EXPECT(roadgen_to_road(network, 4, wheels, 5, cold) == ROADGEN_OK);
    EXPECT(roadgen_to_road_near(network, 4, wheels, 5, &hint, warm, poses) == ROADGEN_OK);
    for (int k = 0; k < 4; ++k) {
      EXPECT(warm[k].road == 2 && warm[k].road == cold[k].road && warm[k].s_m == cold[k].s_m);
      EXPECT(warm[k].t_m == cold[k].t_m && warm[k].height_m == cold[k].height_m && warm[k].lane == cold[k].lane);
      EXPECT_NEAR(poses[k].position_m[2] + warm[k].height_m, wheels[3 * k + 2], 1e-9);
      EXPECT(poses[k].normal[2] == 1);
      if (warm[k].distance_m == 0) EXPECT_NEAR(poses[k].position_m[0], wheels[3 * k], 1e-9);
    }
    EXPECT(hint.road == 2);
  }
  /* Nothing is near: no pose. */
  const double far[] = {1e5, 1e5, 0};
  roadgen_road_point point;
  roadgen_pose pose;
  EXPECT(roadgen_to_road_near(network, 1, far, 5, &hint, &point, &pose) == ROADGEN_OK);
  EXPECT(point.road == -1 && pose.normal[2] == 0 && hint.road == 2);
}

static void candidates(const roadgen_network* network) {
  const double xyz[] = {0, 1, 19};
  roadgen_road_point points[100];
  size_t count = 0;
  EXPECT(roadgen_candidates(network, xyz, 3, 100, points, &count) == ROADGEN_OK);
  EXPECT(count == 2 && points[0].road == 1 && points[1].road == 0);
  EXPECT(roadgen_candidates(network, xyz, 3, 1, points, &count) == ROADGEN_OK);
  EXPECT(count == 2 && points[0].road == 1);
  EXPECT(roadgen_candidates(network, xyz, INFINITY, 0, NULL, &count) == ROADGEN_OK);
  EXPECT(count == 3);
}

static void errors(const roadgen_network* network) {
  const double xyz[] = {0, 0, 0}, s = 1, nan_ = NAN;
  const int64_t road = 0, none = 3, negative = -1;
  roadgen_road_point point;
  roadgen_pose pose;
  size_t count;
  EXPECT(roadgen_to_road(NULL, 1, xyz, 5, &point) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_road(network, 1, NULL, 5, &point) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_road(network, 1, xyz, 5, NULL) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_road(network, 1, xyz, -1, &point) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_road(network, 1, xyz, nan_, &point) == ROADGEN_USAGE_ERROR);
  EXPECT(strstr(roadgen_last_error(), "reach_m") != NULL);
  EXPECT(roadgen_to_road(network, 0, NULL, 5, NULL) == ROADGEN_OK);
  EXPECT(roadgen_candidates(network, xyz, 5, 1, NULL, &count) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_candidates(network, xyz, nan_, 1, &point, &count) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_world(network, 1, &none, &s, &s, &pose) == ROADGEN_USAGE_ERROR);
  EXPECT(strstr(roadgen_last_error(), "3") != NULL);
  EXPECT(roadgen_to_world(network, 1, &negative, &s, &s, &pose) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_world(network, 1, &road, &nan_, &s, &pose) == ROADGEN_USAGE_ERROR);
  EXPECT(roadgen_to_world(network, 1, &road, &s, NULL, &pose) == ROADGEN_USAGE_ERROR);
  /* On an error nothing is written. */
  const int64_t roads[] = {0, 9};
  const double two[] = {1, 1};
  roadgen_pose poses[2];
  poses[0].heading_rad = 77;
  EXPECT(roadgen_to_world(network, 2, roads, two, two, poses) == ROADGEN_USAGE_ERROR && poses[0].heading_rad == 77);
}

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: capi_query_test FILE\n");
    return 2;
  }
  roadgen_network* network = NULL;
  EXPECT(write_network(argv[1]));
  EXPECT(roadgen_network_load(argv[1], &network) == ROADGEN_OK);
  remove(argv[1]);
  if (failures > 0) return 1;
  known_answers(network);
  threads_agree_and_places_come_back(network);
  wheels_with_a_hint(network);
  candidates(network);
  errors(network);
  roadgen_network_free(network);
  printf("%d failures\n", failures);
  return failures > 0;
}
