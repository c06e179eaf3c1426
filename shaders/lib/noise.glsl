// Band-limited noise on a lattice that repeats every NOISE_PERIOD metres, so that coordinates may be reduced by that
// period in double precision before they reach the GPU, and a world far from its origin looks the same.

#define NOISE_PERIOD 4096.0

// A bijective mixer of 32 bits (multiply-xorshift; constants by C. Wellons, public domain, hash-prospector).
FN uint noise_hash(IN(uint) x) {
  uint h = x;
  h ^= h >> 16u;
  h *= 0x7feb352du;
  h ^= h >> 15u;
  h *= 0x846ca68bu;
  h ^= h >> 16u;
  return h;
}

// Uniform in [-1, 1) at a lattice point; cells is the period in cells, a power of two.
FN float noise_lattice(IN(int) i, IN(int) j, IN(int) cells) {
  uint h = noise_hash(uint(i & (cells - 1)) + 0x9e3779b9u * uint(j & (cells - 1)) + uint(cells));
  return float(int(h >> 8u)) * (2.0 / 16777216.0) - 1.0;
}

// Value noise in [-1, 1] with the given wavelength (a power of two, 1/64 to 1024 m), C2: x; and its slopes along x and
// y per metre: y, z.
FN vec3 noise_value_slope(IN(float) x, IN(float) y, IN(float) wavelength) {
  float px = x / wavelength;
  float py = y / wavelength;
  float fx = floor(px);
  float fy = floor(py);
  int i = int(fx);
  int j = int(fy);
  int cells = int(NOISE_PERIOD / wavelength);
  float tx = px - fx;
  float ty = py - fy;
  float wx = tx * tx * tx * (tx * (tx * 6.0 - 15.0) + 10.0);
  float wy = ty * ty * ty * (ty * (ty * 6.0 - 15.0) + 10.0);
  float sx = 30.0 * tx * tx * (tx * (tx - 2.0) + 1.0) / wavelength;
  float sy = 30.0 * ty * ty * (ty * (ty - 2.0) + 1.0) / wavelength;
  float v00 = noise_lattice(i, j, cells);
  float v10 = noise_lattice(i + 1, j, cells);
  float v01 = noise_lattice(i, j + 1, cells);
  float v11 = noise_lattice(i + 1, j + 1, cells);
  float twist = v00 - v10 - v01 + v11;
  return vec3(v00 + (v10 - v00) * wx + (v01 - v00) * wy + twist * wx * wy, (v10 - v00 + twist * wy) * sx,
              (v01 - v00 + twist * wx) * sy);
}

FN float noise_value(IN(float) x, IN(float) y, IN(float) wavelength) {
  return noise_value_slope(x, y, wavelength).x;
}

// How much of a wavelength survives a pixel footprint (both in metres): 1 when well resolved, 0 below two pixels.
FN float noise_band(IN(float) wavelength, IN(float) footprint) {
  return clamp(2.0 - 4.0 * footprint / wavelength, float(0.0), float(1.0));
}

// Sum of octaves from the given wavelength downward, each half as long and weighted by gain; octaves that the
// footprint cannot resolve fade out.
FN float noise_fractal(IN(float) x, IN(float) y, IN(float) wavelength, IN(int) octaves, IN(float) gain,
                       IN(float) footprint) {
  float sum = float(0.0);
  float weight = float(1.0);
  float length_m = wavelength;
  for (int octave = 0; octave < octaves; ++octave) {
    float band = noise_band(length_m, footprint);
    if (!(band > 0.0)) break;  // nor do finer ones
    sum += weight * band * noise_value(x, y, length_m);
    weight *= gain;
    length_m *= 0.5;
  }
  return sum;
}

// Integral of the kernel of the value noise, 1 - (6 x^5 - 15 x^4 + 10 x^3) within a cell of its lattice point, from -1
// to x; in cells.
FN float noise_kernel_integral(IN(float) x) {
  float d = min(abs(x), float(1.0));
  float half_part = d - d * d * d * d * (d * (d - 3.0) + 2.5);
  return x < 0.0 ? 0.5 - half_part : 0.5 + half_part;
}

// The exact mean of noise_value over a box of the given widths about (x, y).
FN float noise_value_box(IN(float) x, IN(float) y, IN(float) wavelength, IN(float) width_x, IN(float) width_y) {
  // Never so narrow that the difference of two integrals loses its digits.
  float wide = max(width_x / wavelength, float(0.03));
  float high = max(width_y / wavelength, float(0.03));
  float x0 = x / wavelength - 0.5 * wide;
  float y0 = y / wavelength - 0.5 * high;
  int i0 = int(floor(x0));
  int j0 = int(floor(y0));
  int i1 = int(floor(x0 + wide)) + 1;
  int j1 = int(floor(y0 + high)) + 1;
  float fx = x0 - float(i0);
  float fy = y0 - float(j0);
  int cells = int(NOISE_PERIOD / wavelength);
  float sum = float(0.0);
  for (int j = j0; j <= j1; ++j) {
    float from_y = fy - float(j - j0);
    float row = float(0.0);
    for (int i = i0; i <= i1; ++i) {
      float from_x = fx - float(i - i0);
      row += (noise_kernel_integral(from_x + wide) - noise_kernel_integral(from_x)) * noise_lattice(i, j, cells);
    }
    sum += (noise_kernel_integral(from_y + high) - noise_kernel_integral(from_y)) * row;
  }
  return sum / (wide * high);
}

// noise_fractal, averaged over a box of the given widths. An octave goes when its mean over so many cells is near 0.
FN float noise_fractal_box(IN(float) x, IN(float) y, IN(float) wavelength, IN(int) octaves, IN(float) gain,
                           IN(float) width_x, IN(float) width_y) {
  float sum = float(0.0);
  float weight = float(1.0);
  float length_m = wavelength;
  for (int octave = 0; octave < octaves; ++octave) {
    float cells = max(width_x / length_m, float(1.0)) * max(width_y / length_m, float(1.0));
    float band = clamp(2.0 - 0.125 * cells, float(0.0), float(1.0));
    if (!(band > 0.0)) break;  // nor do finer ones
    sum += weight * band * noise_value_box(x, y, length_m, width_x, width_y);
    weight *= gain;
    length_m *= 0.5;
  }
  return sum;
}

// The same with slopes, as noise_value_slope gives them. A gain of 1/2 makes ground of equal roughness at all scales.
FN vec3 noise_fractal_slope(IN(float) x, IN(float) y, IN(float) wavelength, IN(int) octaves, IN(float) gain,
                            IN(float) footprint) {
  vec3 sum = vec3(0.0, 0.0, 0.0);
  float weight = float(1.0);
  float length_m = wavelength;
  for (int octave = 0; octave < octaves; ++octave) {
    float band = noise_band(length_m, footprint);
    if (band > 0.0) sum += noise_value_slope(x, y, length_m) * (weight * band);
    weight *= gain;
    length_m *= 0.5;
  }
  return sum;
}
