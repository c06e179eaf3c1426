// What the strips of a road are made of. Albedos in linear light; textures are noise and patterns over (s, t), each
// averaged over the pixel by its own footprint along s and t, in metres.

// The noises that materials are made of: broad stains, grain, tufts, averaged over a pixel over which s changes by sa
// per step to the right and by sb per step up, t by ta and tb. s may be reduced by NOISE_PERIOD; seed: shifts the broad
// stains from road to road; tufts: of grass alone, else 0. Computed once where strips of several materials share a pixel.
// Where the pixel lies askew to the road, four boxes along its slant take the place of one: the spread of each and theirs
// from each other have the pixel's variances and, up to a correlation of 15/16, its covariance.
FN vec3 material_noise(IN(float) s, IN(float) t, IN(float) seed, IN(float) sa, IN(float) sb, IN(float) ta,
                       IN(float) tb, IN(bool) tufts) {
  float wide = sqrt(sa * sa + sb * sb);
  float high = sqrt(ta * ta + tb * tb);
  float slant = (sa * ta + sb * tb) / max(wide * high, float(1e-12));
  float askew = abs(slant) > 0.3 ? min(abs(slant), float(0.9375)) : float(0.0);
  int boxes = askew > 0.0 ? 4 : 1;
  float apart = 0.25 * sqrt(askew / 0.9375);
  float step_s = apart * wide;
  float step_t = slant < 0.0 ? -apart * high : apart * high;
  wide *= sqrt(1.0 - askew);
  high *= sqrt(1.0 - askew);
  vec3 sum = vec3(0.0, 0.0, 0.0);
  for (int i = 0; i < boxes; ++i) {
    float k = float(i) - 0.5 * float(boxes - 1);
    float x = s + k * step_s;
    float y = t + k * step_t;
    sum += vec3(noise_fractal_box(x + 17.0 * seed, y * 4.0, float(32.0), 3, float(0.6), wide, high * 4.0),
                noise_fractal_box(x, y, float(0.25), 5, float(1.3), wide, high) * 0.22,
                noise_fractal_box(x, y, float(2.0), tufts ? 6 : 0, float(0.8), wide, high) * 0.4);
  }
  return sum * (1.0 / float(boxes));
}

// Integral from 0 to x of exp(-6 x^2), within 4e-4. Source: Abramowitz and Stegun, 7.1.27.
FN float material_track_integral(IN(float) x) {
  float z = 2.44948974 * abs(x);
  float p = 1.0 + z * (0.278393 + z * (0.230389 + z * (0.000972 + z * 0.078108)));
  float part = 0.36180068 * (1.0 - 1.0 / (p * p * p * p));
  return x < 0.0 ? -part : part;
}

// Wear by wheels, 0 to 1, averaged from low to high, metres from the lane's middle: two tracks.
FN float material_wheel(IN(float) low, IN(float) high) {
  // Never so narrow that the difference of two integrals loses its digits.
  float apart = max(0.05 - 0.5 * (high - low), float(0.0));
  float a = low - apart;
  float b = high + apart;
  return (material_track_integral(b + 0.8) - material_track_integral(a + 0.8) + material_track_integral(b - 0.8) -
          material_track_integral(a - 0.8)) / (b - a);
}

// Albedo of material m: 0 asphalt, 1 concrete, 2 paving, 3 grass, 4 gravel, 5 curbstone. wheel: 0 to 1 in the wheel
// tracks; noise: material_noise.
FN vec3 material_color(IN(int) m, IN(float) s, IN(float) t, IN(float) wheel, IN(vec3) noise, IN(float) sa,
                       IN(float) sb, IN(float) ta, IN(float) tb) {
  float broad = noise.x;
  float grain = noise.y;
  if (m == 0) return ground_asphalt(wheel, broad, grain);
  if (m == 1) {
    // Slabs of 5 m with dark joints.
    float joint = marking_dash(s, float(5.0), float(0.012), sa, sb);
    return vec3(0.300, 0.294, 0.276) * ((1.0 + 0.07 * broad + 0.10 * grain) * (1.0 - 0.55 * joint) - 0.04 * wheel);
  }
  if (m == 2) {
    float solid = (1.0 - marking_dash(s, float(0.5), float(0.008), sa, sb)) *
                  (1.0 - marking_dash(t, float(0.5), float(0.008), ta, tb));
    return vec3(0.290, 0.270, 0.240) * ((1.0 + 0.10 * broad + 0.14 * grain) * (0.4 + 0.6 * solid));
  }
  if (m == 3) {
    return mix(vec3(0.064, 0.090, 0.030), vec3(0.142, 0.148, 0.064),
               clamp(0.45 + 0.35 * broad + 0.35 * noise.z, float(0.0), float(1.0))) * (1.0 + 0.4 * grain);
  }
  if (m == 4) return vec3(0.235, 0.220, 0.195) * (1.0 + 0.10 * broad + 0.55 * grain);
  float seam = marking_dash(s, float(1.0), float(0.008), sa, sb);
  return vec3(0.360, 0.350, 0.330) * ((1.0 + 0.06 * broad + 0.12 * grain) * (1.0 - 0.6 * seam));
}

FN vec3 material_albedo(IN(int) m, IN(float) s, IN(float) t, IN(float) wheel, IN(float) seed, IN(float) width_s,
                        IN(float) width_t) {
  float none = float(0.0);
  return material_color(m, s, t, wheel, material_noise(s, t, seed, width_s, none, none, width_t, m == 3), width_s, none, none,
                        width_t);
}
