// The share of a distribution of depths with mean moments.x and mean square moments.y that lies at
// or beyond t, at most: Chebyshev's one-tailed inequality (Donnelly and Lauritzen 2006, eq. 5). It
// is an equality for two depths of which t is the farther. Moments that rounding has made
// impossible count as of `minVariance`.
float chebyshev(vec2 moments, float t, float minVariance) {
    float variance = max(moments.y - moments.x * moments.x, minVariance);
    float beyond = t - moments.x;
    return beyond <= 0.0 ? 1.0 : variance / (variance + beyond * beyond);
}
