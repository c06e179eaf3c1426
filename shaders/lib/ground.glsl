// What the ground looks like: grass, rock and snow by slope and height, gravel along roads. Albedos in linear light.

// How bare the ground is, 0 grass to 1 rock. steepness: 1 - normal.z (0 level); altitude: 0 at the lowest, 1 at the
// highest ground; the noises are in about [-1, 1]: broad (hundreds of metres), middle (tens), fine (below a metre).
FN float ground_bareness(IN(float) steepness, IN(float) altitude, IN(float) broad, IN(float) middle, IN(float) fine) {
  float bare = smoothstep(float(0.19), float(0.27), steepness + 0.055 * middle + 0.03 * broad + 0.02 * fine);
  float high = smoothstep(float(0.74), float(0.90), altitude + 0.10 * middle + 0.08 * broad + 0.03 * fine);
  return max(bare, 0.9 * high);
}

FN vec3 ground_grass(IN(float) altitude, IN(float) broad, IN(float) middle, IN(float) fine) {
  vec3 meadow = mix(vec3(0.064, 0.090, 0.030), vec3(0.142, 0.148, 0.064),
                    clamp(0.45 + 0.55 * broad + 0.30 * middle, float(0.0), float(1.0)));
  vec3 alpine = mix(vec3(0.128, 0.122, 0.060), vec3(0.200, 0.176, 0.098),
                    clamp(0.5 + 0.5 * middle + 0.2 * fine, float(0.0), float(1.0)));
  vec3 grass = mix(meadow, alpine, smoothstep(float(0.30), float(0.70), altitude + 0.14 * broad + 0.06 * middle));
  return grass * (1.0 + 0.42 * fine);
}

FN vec3 ground_rock(IN(float) middle, IN(float) fine, IN(float) strata) {
  return mix(vec3(0.085, 0.080, 0.076), vec3(0.250, 0.236, 0.214),
             clamp(0.5 + 0.35 * middle + 0.45 * strata + 0.30 * fine, float(0.0), float(1.0)));
}

FN vec3 ground_gravel(IN(float) fine) { return vec3(0.150, 0.138, 0.118) * (1.0 + 0.25 * fine); }

// What of the ground is snow, 0 to 1.
FN float ground_snowiness(IN(float) steepness, IN(float) altitude, IN(float) broad, IN(float) middle, IN(float) fine) {
  return smoothstep(float(0.84), float(0.90), altitude + 0.09 * broad + 0.07 * middle + 0.03 * fine - 0.45 * steepness);
}

// What of it is the gravel of a road's verge, 0 to 1. road_m: distance from the carriageway's edge; footprint: of the pixel,
// m, over which it is spread.
FN float ground_verge(IN(float) road_m, IN(float) middle, IN(float) fine, IN(float) footprint) {
  float half_width = 0.65 + 0.5 * footprint;
  float within = 1.0 - smoothstep(1.15 - half_width, 1.15 + half_width, road_m + 0.5 * middle + 0.7 * fine);
  return within / (1.0 + 0.4 * footprint);
}

FN vec3 ground_snow() { return vec3(0.80, 0.84, 0.90); }

// Asphalt: lighter in the wheel tracks, darker repairs by the broad noise. wheel: 0 to 1.
FN vec3 ground_asphalt(IN(float) wheel, IN(float) broad, IN(float) grain) {
  float value = 0.085 * (1.0 + 0.10 * broad + 0.22 * grain) + 0.018 * wheel;
  return vec3(value * 1.0, value * 0.995, value * 0.98);
}
