// Markings and edges as functions of (s, t), box-filtered exactly over a pixel's footprint.

// Part of the interval [x - width/2, x + width/2] that lies in [low, high]: the box filter of a stripe.
FN float marking_stripe(IN(float) x, IN(float) low, IN(float) high, IN(float) width) {
  float w = max(width, float(1e-6));
  return clamp((min(x + 0.5 * w, high) - max(x - 0.5 * w, low)) / w, float(0.0), float(1.0));
}

// Integral from 0 to x of the pulse train that is 1 on [n period, n period + on).
FN float marking_pulse_integral(IN(float) x, IN(float) period, IN(float) on) {
  float n = floor(x / period);
  return n * on + min(x - n * period, on);
}

// Box filter of the pulse train: a broken line along s.
FN float marking_dash(IN(float) x, IN(float) period, IN(float) on, IN(float) width) {
  float w = max(width, float(1e-4));
  return clamp((marking_pulse_integral(x + 0.5 * w, period, on) - marking_pulse_integral(x - 0.5 * w, period, on)) / w,
               float(0.0), float(1.0));
}
