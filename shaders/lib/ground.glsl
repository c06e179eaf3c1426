// What the ground looks like: grass, rock, scree and snow by slope and height. Albedos in linear light.

// steepness: 1 - normal.z (0 level); altitude: 0 at the lowest, 1 at the highest ground; the noises are in [-1, 1]:
// broad (hundreds of metres), middle (tens) and fine (below a metre).
FN vec3 ground_albedo(IN(float) steepness, IN(float) altitude, IN(float) broad, IN(float) middle, IN(float) fine) {
  vec3 meadow = mix(vec3(0.070, 0.120, 0.028), vec3(0.140, 0.170, 0.052), clamp(0.5 + 0.55 * broad + 0.25 * middle, float(0.0), float(1.0)));
  vec3 alpine = mix(vec3(0.150, 0.140, 0.070), vec3(0.205, 0.185, 0.105), 0.5 + 0.5 * middle);
  vec3 rock = mix(vec3(0.150, 0.142, 0.135), vec3(0.300, 0.285, 0.262), clamp(0.5 + 0.35 * middle + 0.3 * fine, float(0.0), float(1.0)));
  vec3 snow = vec3(0.82, 0.85, 0.90);

  vec3 grass = mix(meadow, alpine, smoothstep(float(0.35), float(0.75), altitude + 0.12 * broad + 0.05 * middle));
  grass = grass * (1.0 + 0.28 * fine);
  float bare = smoothstep(float(0.16), float(0.30), steepness + 0.05 * middle + 0.03 * broad + 0.02 * fine);
  bare = max(bare, 0.85 * smoothstep(float(0.72), float(0.92), altitude + 0.10 * middle + 0.08 * broad));
  float snowy = smoothstep(float(0.86), float(0.95), altitude + 0.09 * broad + 0.07 * middle - 0.5 * steepness);
  return mix(mix(grass, rock, bare), snow, snowy);
}

// Asphalt: lighter in the wheel tracks, darker repairs by the broad noise. wheel: 0 to 1.
FN vec3 ground_asphalt(IN(float) wheel, IN(float) broad, IN(float) grain) {
  float value = 0.085 * (1.0 + 0.10 * broad + 0.22 * grain) + 0.018 * wheel;
  return vec3(value * 1.0, value * 0.995, value * 0.98);
}
