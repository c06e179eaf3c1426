// A clear sky with a sun, and the haze between the eye and a surface: closed forms chosen for their looks, in linear
// radiance where a white surface lit by sun and sky is about 1.

FN vec3 sky_sun_color() { return vec3(1.75, 1.58, 1.32); }

// Radiance of the sky without the sun's disc. up: sine of the elevation of the direction; toward_sun: cosine of the
// angle to the sun.
FN vec3 sky_gradient(IN(float) up, IN(float) toward_sun) {
  float height = clamp(up, float(0.0), float(1.0));
  vec3 zenith = vec3(0.13, 0.28, 0.62);
  vec3 horizon = vec3(0.60, 0.74, 0.90);
  float fade = pow(1.0 - height, float(3.5));
  vec3 color = mix(zenith, horizon, fade);
  float glow = max(toward_sun, float(0.0));
  float glow2 = glow * glow;
  float glow8 = glow2 * glow2 * glow2 * glow2;
  return color + vec3(0.32, 0.22, 0.10) * (0.35 * glow2 * fade + 0.5 * glow8 * glow8);
}

// The sun's disc with a soft rim.
FN float sky_sun_disc(IN(float) toward_sun) {
  return smoothstep(float(0.99985), float(0.99995), toward_sun);
}

// Part of the light from a surface that arrives through distance_m of air with an e-folding length of range_m.
FN float sky_transmittance(IN(float) distance_m, IN(float) range_m) { return exp(-distance_m / range_m); }

// Light scattered by the sky onto a surface whose normal has the given z.
FN vec3 sky_ambient(IN(float) normal_z) {
  return mix(vec3(0.16, 0.15, 0.12), vec3(0.34, 0.42, 0.56), 0.5 + 0.5 * normal_z);
}

// Filmic curve with a toe and a shoulder that reaches 1. Source: the rational fit of the ACES reference tone curve,
// K. Narkowicz 2015.
FN float sky_tone(IN(float) x) {
  float c = 0.85 * max(x, float(0.0));
  return clamp(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14), float(0.0), float(1.0));
}
