// What surfaces make of light. Directions are unit vectors that point away from the surface: n its normal, l toward the
// light, v toward the eye, h halfway between them; only d, the way that light or a ray travels, points onto it. A BRDF is
// in 1/sr and without the cosine of the light: radiance = BRDF * irradiance of a surface that faces the light * dot(n, l).

#define LIGHT_PI 3.14159265358979

// Half the radius of the sun's disc as sky_sun_disc draws it. A lobe of this alpha mirrors a light without extent at
// light_distribution's peak 1 / (pi alpha^2) times 1/4, which is the disc's own radiance: 1 / (pi radius^2).
#define LIGHT_SUN_ALPHA 0.007

// d mirrored at the surface. d and n may point to the same side.
FN vec3 light_mirrored(IN(vec3) d, IN(vec3) n) { return d - n * (2.0 * dot(n, d)); }

// Light that goes through the surface.
struct LightRefraction {
  vec3 direction;  // of travel, unit; where total, the mirrored one
  bool total;      // nothing goes through
};

// d refracted by Snell's law. Requires: dot(n, d) <= 0. ior: index of refraction of the side that it enters over that of
// the side that it comes from.
FN LightRefraction light_refracted(IN(vec3) d, IN(vec3) n, IN(float) ior) {
  float across = 1.0 / ior;
  float into = -dot(n, d);
  float k = 1.0 - across * across * (1.0 - into * into);
  if (k < 0.0) return LightRefraction(light_mirrored(d, n), true);
  return LightRefraction(normalize(d * across + n * (across * into - sqrt(k))), false);
}

// Part of unpolarised light that a smooth surface between two dielectrics reflects, exactly. cosine: of the angle between
// the light and the normal, in [0, 1]; ior: as in light_refracted. 1 where all is reflected.
// Source: Fresnel's equations, such as M. Born, E. Wolf, Principles of Optics, section 1.5.2.
FN float light_fresnel(IN(float) cosine, IN(float) ior) {
  float k = ior * ior - 1.0 + cosine * cosine;
  if (k <= 0.0) return ior == 1.0 ? float(0.0) : float(1.0);
  float g = sqrt(k);  // ior * the cosine on the other side
  float across = (cosine - g) / (cosine + g);
  float along = (ior * ior * cosine - g) / (ior * ior * cosine + g);
  return 0.5 * (across * across + along * along);
}

// The same to 0.03 for the usual glass, by the reflectance at normal incidence, which metals colour. Source: C. Schlick 1994.
FN vec3 light_schlick(IN(vec3) f0, IN(float) cosine) {
  float c = 1.0 - clamp(cosine, float(0.0), float(1.0));
  float c2 = c * c;
  return f0 + (vec3(1.0, 1.0, 1.0) - f0) * (c2 * c2 * c);
}

// Trowbridge and Reitz's distribution of microfacets (GGX), 1/sr: its integral with dot(n, h) over the hemisphere is 1.
// The sine comes from the cross product, since 1 - dot(n, h)^2 has no digits left in float where the lobe is narrow.
// Source: glTF 2.0, appendix B.3.2, where alpha is the square of the roughness.
FN float light_distribution(IN(vec3) n, IN(vec3) h, IN(float) alpha) {
  float nh = dot(n, h);
  if (!(nh > 0.0)) return float(0.0);
  vec3 c = vec3(n.y * h.z - n.z * h.y, n.z * h.x - n.x * h.z, n.x * h.y - n.y * h.x);
  float a = alpha * alpha;
  float t = dot(c, c) + a * nh * nh;
  return a / (LIGHT_PI * t * t);
}

// Smith's shadowing and masking of the same, each by itself, over 4 dot(n, l) dot(n, v). Source: glTF 2.0, appendix B.3.2.
FN float light_visibility(IN(float) nl, IN(float) nv, IN(float) alpha) {
  float a = alpha * alpha;
  return 1.0 / max((nl + sqrt(a + (1.0 - a) * nl * nl)) * (nv + sqrt(a + (1.0 - a) * nv * nv)), float(1e-12));
}

// A surface of metal-roughness or Phong's: what of it is diffuse, and what glosses.
struct LightSurface {
  vec3 diffuse;    // albedo
  vec3 f0;         // metal-roughness: reflectance at normal incidence; Phong: of the whole lobe
  float alpha;     // metal-roughness: of the lobe; Phong: 0
  float exponent;  // Phong: of the lobe; metal-roughness: 0
};

// Source: glTF 2.0, appendix B.2 and B.3.5: dielectrics reflect by their index of refraction, 0.04 at 1.5.
FN LightSurface light_metal_roughness(IN(vec3) base, IN(float) metallic, IN(float) roughness, IN(float) ior) {
  float r = (ior - 1.0) / (ior + 1.0);
  return LightSurface(base * (1.0 - metallic), mix(vec3(r * r, r * r, r * r), base, metallic), roughness * roughness,
                      float(0.0));
}

// Phong's, made to conserve energy: what the lobe takes is not there for the diffuse part. exponent >= 1.
// Source: E. Lafortune, Y. Willems 1994.
FN LightSurface light_phong(IN(vec3) base, IN(vec3) specular, IN(float) exponent) {
  return LightSurface(base * (vec3(1.0, 1.0, 1.0) - specular), specular, float(0.0), exponent);
}

// The BRDF. Requires: n, l, v unit. 0 where light or eye are behind the surface. Reciprocal: l and v may change places.
// No more than the light that falls on it is reflected: the diffuse part has what enters through the surface and leaves
// through it again, where glTF's example takes 1 less Fresnel's part at h, by which white dielectrics would gain up to 30 %.
FN vec3 light_brdf_phong(IN(LightSurface) s, IN(vec3) n, IN(vec3) l, IN(vec3) v) {
  float nl = dot(n, l);
  float nv = dot(n, v);
  if (!(nl > 0.0 && nv > 0.0)) return vec3(0.0, 0.0, 0.0);
  float toward = max(2.0 * nl * nv - dot(l, v), float(0.0));  // of the mirrored light, toward the eye
  float lobe = (s.exponent + 2.0) / (2.0 * LIGHT_PI) * pow(toward, s.exponent);
  return s.diffuse * float(1.0 / LIGHT_PI) + s.f0 * lobe;
}

FN vec3 light_brdf_metal_roughness(IN(LightSurface) s, IN(vec3) n, IN(vec3) l, IN(vec3) v) {
  float nl = dot(n, l);
  float nv = dot(n, v);
  if (!(nl > 0.0 && nv > 0.0)) return vec3(0.0, 0.0, 0.0);
  vec3 h = normalize(l + v);
  vec3 fresnel = light_schlick(s.f0, dot(v, h));
  float lobe = light_distribution(n, h, s.alpha) * light_visibility(nl, nv, s.alpha);
  vec3 white = vec3(1.0, 1.0, 1.0);
  vec3 entering = (white - light_schlick(s.f0, nl)) * (white - light_schlick(s.f0, nv));
  return entering * s.diffuse * float(1.0 / LIGHT_PI) + fresnel * lobe;
}

FN vec3 light_brdf(IN(LightSurface) s, IN(vec3) n, IN(vec3) l, IN(vec3) v) {
  if (s.exponent > 0.0) return light_brdf_phong(s, n, l, v);
  return light_brdf_metal_roughness(s, n, l, v);
}

// Half vector of the lobe at (u, w) in the unit square, about z, so that even samples fall by light_distribution times
// dot(n, h). Source: glTF 2.0 sample viewer's reference, B. Walter et al. 2007, Eq. 35 and 36.
FN vec3 light_half_vector(IN(float) u, IN(float) w, IN(float) alpha) {
  float a = alpha * alpha;
  float below = 1.0 + (a - 1.0) * u;
  float sine = sqrt(a * u / below);
  float turn = 2.0 * LIGHT_PI * w;
  return vec3(sine * cos(turn), sine * sin(turn), sqrt((1.0 - u) / below));
}

// Real spherical harmonic i, in [0, 9), at a direction: bands 0 to 2. Source: R. Ramamoorthi, P. Hanrahan 2001, Eq. 3.
FN float light_harmonic(IN(int) i, IN(vec3) d) {
  if (i == 0) return float(0.28209479);
  if (i == 1) return 0.48860251 * d.y;
  if (i == 2) return 0.48860251 * d.z;
  if (i == 3) return 0.48860251 * d.x;
  if (i == 4) return 1.09254843 * d.x * d.y;
  if (i == 5) return 1.09254843 * d.y * d.z;
  if (i == 6) return 0.31539157 * (3.0 * d.z * d.z - 1.0);
  if (i == 7) return 1.09254843 * d.x * d.z;
  return 0.54627422 * (d.x * d.x - d.y * d.y);
}

// What a clamped cosine leaves of a harmonic, over pi: radiance that a white diffuse surface sends out is the sum of
// light's coefficients times this times the harmonic at its normal. Source: as above, Eq. 8.
FN float light_harmonic_cosine(IN(int) i) {
  return i == 0 ? float(1.0) : (i < 4 ? float(0.66666666667) : float(0.25));
}
