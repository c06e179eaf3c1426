// Fragment outputs: the picture, or the data channels that a simulator reads beside it.
#ifdef CHANNELS
layout(location = 0) out vec4 out_road;     // road index, s, t, lane; or -2 - junction, x, y, 0; or -1
layout(location = 1) out vec4 out_normal;   // unit normal, ENU
layout(location = 2) out vec2 out_label;    // label (0 nothing, 1 ground, 2 carriageway, 3 marking, 4 structure, 5 object), instance
#else
layout(location = 0) out vec4 out_color;    // linear; the framebuffer encodes sRGB
#endif
