/* roadgen for simulators: the C interface.
 *
 * Load a road network, place a camera, render into your own memory, and ask where on which road a point lies. Link with
 * `roadgen::roadgen` of the CMake package roadgen, or with pkg-config roadgen.
 *
 * Frames and units: metres, right-handed ENU (x east, y north, z up); s along a road from its start, t to the left.
 * Errors: every function that can fail returns a roadgen_status; the text is kept per thread (roadgen_last_error).
 * Nothing is thrown across this interface. Threads: a handle may be used by one thread at a time; queries
 * (roadgen_to_road, roadgen_to_road_near, roadgen_candidates, roadgen_to_world) on one network may run in many threads
 * at once.
 */
#ifndef ROADGEN_CAPI_ROADGEN_H
#define ROADGEN_CAPI_ROADGEN_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define ROADGEN_API __attribute__((visibility("default")))
#else
#define ROADGEN_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum roadgen_status {
  ROADGEN_OK = 0,
  ROADGEN_DATA_ERROR = 1,   /* a file or its content is at fault */
  ROADGEN_USAGE_ERROR = 2,  /* an argument is out of its range */
  ROADGEN_CONTEXT_ERROR = 3 /* no OpenGL context, or the GPU refused */
} roadgen_status;

/* What went wrong in the last failing call of this thread: one line. Valid until the next failing call. Never NULL. */
ROADGEN_API const char* roadgen_last_error(void);

/* "0.1.0" */
ROADGEN_API const char* roadgen_version(void);

/* ---- Network ---- */

typedef struct roadgen_network roadgen_network;

/* Reads an OpenDRIVE file (.xodr) as `roadgen import` writes it. On failure *network is NULL. */
ROADGEN_API roadgen_status roadgen_network_load(const char* path, roadgen_network** network);
/* NULL is allowed. */
ROADGEN_API void roadgen_network_free(roadgen_network* network);

ROADGEN_API size_t roadgen_road_count(const roadgen_network* network);
/* Id and length of road `index` in [0, count). Valid as long as the network; NULL and 0 out of range. */
ROADGEN_API const char* roadgen_road_id(const roadgen_network* network, size_t index);
ROADGEN_API double roadgen_road_length_m(const roadgen_network* network, size_t index);

/* ---- Queries ---- */

typedef struct roadgen_road_point {
  int64_t road;      /* index, or -1: no road within reach, or an area through which none leads */
  int64_t junction;  /* index of the junction on whose area the point lies, or -1; the road is one that leads through */
  int lane;          /* OpenDRIVE's id: positive to the left, negative to the right; 0 beside all lanes */
  double s_m, t_m;   /* along, and to the left of, the road's reference line */
  double height_m;   /* of the asked point above the surface */
  double distance_m; /* horizontally to the carriageway: 0 on it */
} roadgen_road_point;

typedef struct roadgen_pose {
  double position_m[3];                    /* on the surface */
  double heading_rad, pitch_rad, roll_rad; /* counter-clockwise from east; nose up; right side down */
  double curvature_per_m;                  /* of the reference line, positive to the left */
  double grade;                            /* rise per metre along the road: tan(pitch) */
  double normal[3];                        /* of the surface, unit, upward */
} roadgen_pose;

/* Where a series of queries is: makes the next one nearby several times as fast, and changes no answer. One for each
 * vehicle, kept from frame to frame; not to be shared between threads. */
typedef struct roadgen_hint {
  uint32_t road, segment;
} roadgen_hint;
/* Of a series that begins: roadgen_hint hint = ROADGEN_HINT_NONE; */
#define ROADGEN_HINT_NONE \
  { 0xffffffffu, 0 }

/* World to road for `count` points xyz[3 * i]: the road that each belongs to, of those whose carriageway is within
 * reach_m (0 or more, may be infinite) of it horizontally: one that holds it, else the nearest; z tells a bridge from the
 * road below. s and t are exact: roadgen_to_world gives the point back within a micrometre. A point that is not finite
 * has no road. Does not allocate. */
ROADGEN_API roadgen_status roadgen_to_road(const roadgen_network* network, size_t count, const double* xyz,
                                           double reach_m, roadgen_road_point* points);
/* The same for points near one another, as the wheels of a vehicle: each is the hint of the next. hint is read and set;
 * poses: of the surface at each point, all 0 where there is none; may be NULL, and so may hint. */
ROADGEN_API roadgen_status roadgen_to_road_near(const roadgen_network* network, size_t count, const double* xyz,
                                                double reach_m, roadgen_hint* hint, roadgen_road_point* points,
                                                roadgen_pose* poses);
/* All roads whose carriageway is within reach_m of the point xyz[0..2], best first in the order of roadgen_to_road, a road
 * that passes twice twice: as many as `room`, and in *count how many there are. points may be NULL where room is 0. */
ROADGEN_API roadgen_status roadgen_candidates(const roadgen_network* network, const double* xyz, double reach_m,
                                              size_t room, roadgen_road_point* points, size_t* count);
/* Road to world for `count` triples: road index, s, t; on a junction's area through which the road leads, on the area. s
 * is clamped to the road, wrapped where it is closed. On an error no pose is written. Does not allocate. */
ROADGEN_API roadgen_status roadgen_to_world(const roadgen_network* network, size_t count, const int64_t* road,
                                            const double* s_m, const double* t_m, roadgen_pose* poses);

/* ---- Rendering ---- */

typedef struct roadgen_renderer roadgen_renderer;

typedef enum roadgen_context {
  ROADGEN_CONTEXT_OSMESA = 0, /* software, needs neither GPU nor display */
  ROADGEN_CONTEXT_EGL = 1,    /* no display: the default EGL device */
  ROADGEN_CONTEXT_WINDOW = 2  /* a hidden window's context */
} roadgen_context;

typedef struct roadgen_camera {
  double position_m[3];
  double yaw_deg, pitch_deg, roll_deg; /* counter-clockwise from east; up; right side down */
  double fov_deg;                      /* vertical, in (0, 170] */
  double far_m;                        /* whole tiles of roads beyond it are left out; 0 or less: none is */
} roadgen_camera;

/* A renderer for the network, with ground made from the DEM file (SRTM .hgt, GeoTIFF, ASCII grid), or from the roads'
 * own heights where dem_path is NULL. The network is copied. On failure *renderer is NULL. */
ROADGEN_API roadgen_status roadgen_renderer_create(const roadgen_network* network, const char* dem_path,
                                                   roadgen_context context, roadgen_renderer** renderer);
ROADGEN_API void roadgen_renderer_free(roadgen_renderer* renderer);

ROADGEN_API roadgen_status roadgen_set_camera(roadgen_renderer* renderer, const roadgen_camera* camera);

/* Replaces the objects beside the roads by those of a scene: of the file `path`, or of the text `json`, of which `path` is
 * then the name, for errors and for the folder in which other files are sought (may be NULL: the current one). Both NULL: no
 * objects. Schema: README, "Scene files". network: on whose roads objects with a place stand, the renderer's; may be NULL
 * where none has one. On an error the objects are as they were, and the last error names line and path of the fault. */
ROADGEN_API roadgen_status roadgen_set_props(roadgen_renderer* renderer, const roadgen_network* network,
                                             const char* path, const char* json);

/* What objects mirror and the picture's sky: a panorama, .exr or .hdr. */
ROADGEN_API roadgen_status roadgen_set_environment(roadgen_renderer* renderer, const char* path);

/* Renders width x height pixels into the caller's memory, rows from the top left. color: RGBA, 4 bytes a pixel, sRGB;
 * depth_m: one float a pixel, distance along the view axis in metres, +inf where nothing is. Either may be NULL. */
ROADGEN_API roadgen_status roadgen_render(roadgen_renderer* renderer, int width, int height, uint8_t* color,
                                          float* depth_m);

#ifdef __cplusplus
}
#endif

#endif
