/* Offsets of the RT32's forms and of a table, in loops that a compiler turns into vectors.

   LOOPS names the set. Products and sums are fused only where FUSED says so (no contraction by
   the compiler), so that a point is the same number wherever it stands in an array. The formulae
   are those of pyport.pointing.exact and approximate, arranged as in pyport.pointing.swift; the
   two turns of azimuth are one angle, that of the product of their directions. */

#include "loops.h"
#include "polynomials.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Points of a block: what stands between an angle's sine and the offset stays in the first cache. */
#define BLOCK 128

#ifdef __FP_FAST_FMA
#define FUSED(a, b, c) __builtin_fma(a, b, c)
#else
#define FUSED(a, b, c) ((a) * (b) + (c))
#endif

#define INLINE static inline __attribute__((always_inline))
#define EACH _Pragma("omp simd")

#define PI 0x1.921fb54442d18p+1
#define HALF_PI 0x1.921fb54442d18p+0
#define HALF_PI_LOW 0x1.1a62633145c07p-54
#define DEGREE 0x1.1df46a2529d39p-6

/* pi/2 in three parts of 33 bits, so that products with whole numbers below 2^20 are exact. */
#define HALF_PI_1 0x1.921fb544p+0
#define HALF_PI_2 0x1.0b4611a6p-34
#define HALF_PI_3 0x1.3198a2e037073p-69
/* Larger angles [rad] are left to others. */
#define LARGEST_ANGLE 1e6
/* Added to a number it rounds it to a whole one, which then stands in its last bits. */
#define ROUNDER 0x1.8p52

INLINE double polynomial(const double *coefficient, int terms, double z)
{
    double sum = coefficient[terms - 1];
    for (int n = terms - 2; n >= 0; n--)
        sum = FUSED(sum, z, coefficient[n]);
    return sum;
}

INLINE double magnitude(double x) { return __builtin_fabs(x); }

INLINE double signed_as(double x, double sign) { return __builtin_copysign(x, sign); }

/* Turn the sign where the bit of value two is set. */
INLINE double turned(double x, uint64_t quarters)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits ^= (quarters & 2) << 62;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

INLINE void sine_and_cosine(double angle, double *sine, double *cosine)
{
    double shifted = FUSED(angle, 2 / PI, ROUNDER), whole = shifted - ROUNDER;
    double r = ((angle - whole * HALF_PI_1) - whole * HALF_PI_2) - whole * HALF_PI_3;
    double z = r * r, half = 0.5 * z, near = 1 - half;
    double s = FUSED(r * z, polynomial(SINE, SINE_TERMS, z), r);
    double c = near + FUSED(z * z, polynomial(COSINE, COSINE_TERMS, z), (1 - near) - half);
    uint64_t quarters;
    memcpy(&quarters, &shifted, sizeof quarters);
    int odd = quarters & 1;
    *sine = turned(odd ? c : s, quarters);
    *cosine = turned(odd ? s : c, quarters + 1);
}

/* Of x within a half; z is its square. */
INLINE double small_arcsine(double x, double z)
{
    return FUSED(x * z, polynomial(ARCSINE, ARCSINE_TERMS, z), x);
}

INLINE double arcsine(double x)
{
    double a = magnitude(x), z = 0.5 * (1 - a);
    double large = HALF_PI - (2 * small_arcsine(__builtin_sqrt(z), z) - HALF_PI_LOW);
    return a > 0.5 ? signed_as(large, x) : small_arcsine(x, x * x);
}

INLINE double arctangent(double y, double x)
{
    double up = magnitude(y), along = magnitude(x);
    int steep = up > along;
    double more = steep ? up : along, less = steep ? along : up;
    int middle = less > 0.41421356237309503 * more;
    double above = middle ? less - more : less, below = middle ? less + more : more;
    double t = (below == 0) & (above == 0) ? 0 : above / below, z = t * t;
    double angle = FUSED(t * z, polynomial(ARCTANGENT, ARCTANGENT_TERMS, z), t);
    angle = middle ? HALF_PI / 2 + (angle + HALF_PI_LOW / 2) : angle;
    angle = steep ? HALF_PI - (angle - HALF_PI_LOW) : angle;
    angle = signed_as(1, x) < 0 ? PI - (angle - 2 * HALF_PI_LOW) : angle;
    return signed_as(angle, y);
}

/* What depends on azimuth alone. */
struct azimuths {
    double *sine, *cosine, *across, *along, *curve;
};

INLINE size_t of_azimuths(const double *p, size_t n, const double *az, struct azimuths at)
{
    size_t large = 0;
    _Pragma("omp simd reduction(+ : large)") for (size_t i = 0; i < n; i++)
    {
        double sine, cosine, angle = az[i] - p[TOWARD];
        large += magnitude(angle) > LARGEST_ANGLE;
        sine_and_cosine(angle, &sine, &cosine);
        at.sine[i] = sine;
        at.cosine[i] = cosine;
        at.across[i] = (cosine * p[AZ_BY_SINE] - sine * p[AZ_BY_COSINE]) * sine + p[AZ_ZERO];
        at.along[i] = (cosine * p[ALT_BY_SINE] - sine * p[ALT_BY_COSINE]) * sine + p[ALT_ZERO];
    }
    EACH for (size_t i = 0; i < n; i++)
    {
        /* the altitude of the step: pyport.pointing.jump */
        double sine, cosine, west = (az[i] / DEGREE - 95) / 90;
        sine_and_cosine(az[i] / 2, &sine, &cosine);
        west = (west * west * 15 + 55) * DEGREE;
        at.curve[i] = az[i] <= 0 ? (65 + 7 * cosine) * DEGREE : west;
    }
    return large;
}

/* What depends on altitude alone. */
struct altitudes {
    double *sine, *cosine, *facing, *sag, *height;
};

INLINE size_t of_altitudes(int exact, const double *p, size_t n, const double *alt,
                           struct altitudes at)
{
    size_t large = 0;
    _Pragma("omp simd reduction(+ : large)") for (size_t i = 0; i < n; i++)
    {
        double sine, cosine, h = alt[i];
        large += magnitude(h) > LARGEST_ANGLE;
        sine_and_cosine(h, &sine, &cosine);
        at.sine[i] = sine;
        at.cosine[i] = cosine;
        at.facing[i] = exact ? signed_as(1, cosine) : h > HALF_PI ? -1 : 1;
        at.sag[i] = cosine * p[SAG] + sine * p[SAG_SINE];
        /* below the horizon the step is there whatever the azimuth, on it nowhere */
        at.height[i] = h > 0 ? h : h < 0 ? __builtin_inf() : -__builtin_inf();
    }
    return large;
}

/* Sine and squared cosine of the altitude that the tilted mount reads, and the turn of azimuth
   as an angle's two sides: eqs. 1 to 4. */
struct read {
    double sine, square, turn, dot;
};

INLINE struct read tilted(const double *p, double az_sine, double az_cosine, double sine,
                          double cosine, double facing)
{
    double leaning = cosine * p[LEAN], along = leaning * az_cosine * facing;
    double m = FUSED(along, p[LEAN_SHARE], sine), product = along * m;
    double dot = FUSED(cosine, cosine, -product);
    return (struct read){FUSED(sine, p[UPRIGHT], along),
                         FUSED(m * m, p[LEAN_SQUARED], -product) + dot,
                         leaning * az_sine * m, dot};
}

INLINE double wrapped(double angle)
{
    double turns = __builtin_floor((angle + PI) * (0.5 / PI));
    return angle >= PI || angle < -PI ? angle - turns * (2 * PI) : angle;
}

/* Eqs. 15 and 16: sine and cosine of the turn of azimuth by skew and box, times the cosine of the
   altitude read (the cosine's square may be negative), and the sine of the angle from the true
   altitude to the one that is set. */
struct set {
    double across, square, level, rise;
};

INLINE struct set skewed(const double *p, struct read r, double sine, double cosine, double facing)
{
    double across = FUSED(r.sine, p[ACROSS_BY_SINE], p[ACROSS_ZERO]);
    double square = FUSED(-across, across, r.square);
    double level = __builtin_sqrt(square < 0 ? 0 : square);
    double rise = (r.sine + p[RISE_ZERO]) * (cosine * p[RISE_BY_COSINE])
                  - facing * level * (sine * p[RISE_BY_SINE]);
    return (struct set){across * facing, square, level, rise};
}

INLINE double step(const double *p, double height, double curve)
{
    return height >= curve ? p[JUMP] : 0 * p[JUMP];
}

INLINE void exact_offsets(const double *p, size_t n, struct azimuths az, struct altitudes alt,
                          double *d_az, double *d_alt)
{
    size_t rare = 0;
    _Pragma("omp simd reduction(+ : rare)") for (size_t i = 0; i < n; i++)
    {
        double sine = alt.sine[i], cosine = alt.cosine[i], facing = alt.facing[i];
        struct read r = tilted(p, az.sine[i], az.cosine[i], sine, cosine, facing);
        struct set s = skewed(p, r, sine, cosine, facing);
        double turn = arctangent(r.turn * s.level + s.across * r.dot,
                                 r.dot * s.level - r.turn * s.across);
        rare += (s.square < 0) | (magnitude(s.rise) > 0.5);
        d_az[i] = wrapped(turn + p[SOUTH] * (facing - 1) + az.across[i]);
        d_alt[i] = small_arcsine(s.rise, s.rise * s.rise) + az.along[i] + alt.sag[i]
                   + step(p, alt.height[i], az.curve[i]);
    }
    for (size_t i = 0; rare && i < n; i++)
    {
        double sine = alt.sine[i], cosine = alt.cosine[i], facing = alt.facing[i];
        struct read r = tilted(p, az.sine[i], az.cosine[i], sine, cosine, facing);
        struct set s = skewed(p, r, sine, cosine, facing);
        double change = arcsine(s.rise);
        if (s.square < 0)
        {
            /* no setting reaches the source: the azimuth has stopped */
            double reach = signed_as(__builtin_sqrt(r.square > 0 ? r.square : 0), facing * s.across);
            double up = r.sine + p[ACROSS_BY_SINE] * reach;
            change = arctangent(up * cosine, up * sine);
        }
        if ((s.square < 0) | (magnitude(s.rise) > 0.5))
            d_alt[i] = change + az.along[i] + alt.sag[i] + step(p, alt.height[i], az.curve[i]);
    }
}

INLINE void approximate_offsets(const double *p, size_t n, struct azimuths az,
                                struct altitudes alt, double *d_az, double *d_alt)
{
    /* eqs. 18 and 19 */
    EACH for (size_t i = 0; i < n; i++)
    {
        double across = (az.sine[i] * p[LEAN] + p[SIGMA]) * alt.sine[i] + p[BETA];
        d_az[i] = wrapped(across / alt.cosine[i] + az.across[i]);
        d_alt[i] = az.cosine[i] * p[LEAN] * alt.facing[i] + az.along[i] + alt.sag[i]
                   + step(p, alt.height[i], az.curve[i]);
    }
}

INLINE void offsets(int exact, const double *p, size_t n, struct azimuths az,
                    struct altitudes alt, double *d_az, double *d_alt)
{
    if (exact)
        exact_offsets(p, n, az, alt, d_az, d_alt);
    else
        approximate_offsets(p, n, az, alt, d_az, d_alt);
}

static size_t scattered(int exact, const double *p, size_t n, const double *az, const double *alt,
                        double *d_az, double *d_alt)
{
    double room[10][BLOCK];
    struct azimuths by_az = {room[0], room[1], room[2], room[3], room[4]};
    struct altitudes by_alt = {room[5], room[6], room[7], room[8], room[9]};
    size_t large = 0;
    for (size_t low = 0; low < n; low += BLOCK)
    {
        size_t some = n - low < BLOCK ? n - low : BLOCK;
        large += of_azimuths(p, some, az + low, by_az);
        large += of_altitudes(exact, p, some, alt + low, by_alt);
        offsets(exact, p, some, by_az, by_alt, d_az + low, d_alt + low);
    }
    return large;
}

static size_t grid(int exact, const double *p, size_t columns, const double *az, size_t rows,
                   const double *alt, double *room, double *d_az, double *d_alt)
{
    struct azimuths whole = {room, room + columns, room + 2 * columns, room + 3 * columns,
                             room + 4 * columns};
    size_t large = of_azimuths(p, columns, az, whole);
    double one[5], all[5][BLOCK];
    struct altitudes here = {one, one + 1, one + 2, one + 3, one + 4};
    struct altitudes spread = {all[0], all[1], all[2], all[3], all[4]};
    for (size_t row = 0; row < rows; row++)
    {
        large += of_altitudes(exact, p, 1, alt + row, here);
        for (int k = 0; k < 5; k++)
            EACH for (size_t i = 0; i < BLOCK; i++) all[k][i] = one[k];
        for (size_t low = 0; low < columns; low += BLOCK)
        {
            size_t some = columns - low < BLOCK ? columns - low : BLOCK, at = row * columns + low;
            struct azimuths by_az = {whole.sine + low, whole.cosine + low, whole.across + low,
                                     whole.along + low, whole.curve + low};
            offsets(exact, p, some, by_az, spread, d_az + at, d_alt + at);
        }
    }
    return large;
}

static size_t look_up(const struct table *t, size_t n, const double *az, const double *zd,
                      double *d_az, double *d_zd)
{
    double per_az = (double)(t->rows - 1) / (t->last_az - t->first_az);
    double per_zd = (double)(t->row - 1) / (t->last_zd - t->first_zd);
    size_t beyond = 0;
    int32_t cell[BLOCK];
    double east[BLOCK], north[BLOCK];
    for (size_t low = 0; low < n; low += BLOCK)
    {
        size_t some = n - low < BLOCK ? n - low : BLOCK;
        _Pragma("omp simd reduction(+ : beyond)") for (size_t i = 0; i < some; i++)
        {
            double u = az[low + i], v = zd[low + i];
            int inside = (u >= t->first_az) & (u <= t->last_az) & (v >= t->first_zd)
                         & (v <= t->last_zd);
            beyond += !inside;
            u = inside ? (u - t->first_az) * per_az : 0;
            v = inside ? (v - t->first_zd) * per_zd : 0;
            int32_t k = (int32_t)u, m = (int32_t)v;
            k = k < (int32_t)t->rows - 2 ? k : (int32_t)t->rows - 2;
            m = m < (int32_t)t->row - 2 ? m : (int32_t)t->row - 2;
            cell[i] = k * (int32_t)t->row + m;
            east[i] = u - k;
            north[i] = v - m;
        }
        for (size_t i = 0; i < some; i++)
        {
            double u = east[i], v = north[i], both = u * v, next = v - both, over = u - both;
            double here = (1 - u) - next;
            const double *a = t->az + cell[i], *z = t->zd + cell[i];
            d_az[low + i] = a[0] * here + a[1] * next + a[t->row] * over + a[t->row + 1] * both;
            d_zd[low + i] = z[0] * here + z[1] * next + z[t->row] * over + z[t->row + 1] * both;
        }
    }
    return beyond;
}

static double product(size_t n, const double *a, const double *b)
{
    double sum = 0;
    _Pragma("omp simd reduction(+ : sum)") for (size_t i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static void gram(size_t k, size_t n, const double *columns, const double *weight,
                 const double *target, double *normal, double *right)
{
    double heavy[2 * BLOCK];
    for (size_t a = 0; a < k * k; a++)
        normal[a] = 0;
    for (size_t a = 0; a < k; a++)
        right[a] = 0;
    for (size_t low = 0; low < n; low += 2 * BLOCK)
    {
        size_t some = n - low < 2 * BLOCK ? n - low : 2 * BLOCK;
        for (size_t a = 0; a < k; a++)
        {
            const double *column = columns + a * n + low;
            EACH for (size_t i = 0; i < some; i++) heavy[i] = column[i] * weight[low + i];
            for (size_t b = 0; b <= a; b++)
                normal[a * k + b] += product(some, heavy, columns + b * n + low);
            right[a] += product(some, column, target + low);
        }
    }
    for (size_t a = 0; a < k; a++)
        for (size_t b = 0; b < a; b++)
            normal[b * k + a] = normal[a * k + b];
}

/* Columns that are whitened at a time: what is carried along of them stays in the first cache. */
#define SIDE_BY_SIDE 128

/* Of every row what each term keeps until then, and what it takes of the row; the variance given the
   rows before. The covariance of Ornstein-Uhlenbeck processes is semiseparable, and so is its
   triangle: Foreman-Mackey et al. 2017, AJ 154, 220. */
static int factored(size_t n, size_t terms, const double *time, const double *rate,
                    const double *power, const double *variance, double *known, double *decay,
                    double *weight, double *d)
{
    double total = 0;
    for (size_t a = 0; a < terms; a++)
        total += power[a];
    for (size_t a = 0; a < terms * terms; a++)
        known[a] = 0;
    for (size_t i = 0; i < n; i++, decay += terms, weight += terms)
    {
        double before = i ? d[i - 1] : 0, left = variance[i] + total;
        const double *last = i ? weight - terms : NULL;
        for (size_t a = 0; a < terms; a++)
            decay[a] = i ? exp(rate[a] * (time[i - 1] - time[i])) : 0;
        for (size_t a = 0; a < terms; a++)
        {
            double sum = 0;
            for (size_t b = 0; i && b < terms; b++)
            {
                double *of = known + a * terms + b;
                *of = decay[a] * (*of + before * last[a] * last[b]) * decay[b];
                sum += power[b] * *of;
            }
            weight[a] = sum;
            left -= sum * power[a];
        }
        if (!(left > 0))
            return 0;
        for (size_t a = 0; a < terms; a++)
            weight[a] = (1 - weight[a]) / left;
        d[i] = left;
    }
    return 1;
}

static int whiten(size_t n, const int64_t *rows, size_t terms, size_t k, const double *time,
                  const double *rate, const double *power, const double *variance,
                  const double *columns, double *room, double *d, double *white)
{
    double *known = room, *decay = known + terms * terms, *weight = decay + n * terms;
    double *carried = weight + n * terms, last[SIDE_BY_SIDE], sum[SIDE_BY_SIDE];
    if (!factored(n, terms, time, rate, power, variance, known, decay, weight, d))
        return 0;
    for (size_t low = 0; low < k; low += SIDE_BY_SIDE)
    {
        size_t some = k - low < SIDE_BY_SIDE ? k - low : SIDE_BY_SIDE;
        for (size_t c = 0; c < terms * SIDE_BY_SIDE; c++)
            carried[c] = 0;
        for (size_t c = 0; c < SIDE_BY_SIDE; c++)
            last[c] = 0;
        for (size_t i = 0; i < n; i++)
        {
            const double *from = columns + (size_t)rows[i] * k + low;
            double *to = white + (size_t)rows[i] * k + low, scale = 1 / __builtin_sqrt(d[i]);
            EACH for (size_t c = 0; c < some; c++) sum[c] = 0;
            for (size_t a = 0; a < terms; a++)
            {
                double share = i ? weight[(i - 1) * terms + a] : 0, fading = decay[i * terms + a];
                double strength = power[a], *of = carried + a * SIDE_BY_SIDE;
                EACH for (size_t c = 0; c < some; c++)
                {
                    of[c] = fading * (of[c] + share * last[c]);
                    sum[c] += strength * of[c];
                }
            }
            EACH for (size_t c = 0; c < some; c++)
            {
                last[c] = from[c] - sum[c];
                to[c] = last[c] * scale;
            }
        }
    }
    return 1;
}

/* Eight numbers, wherever they stand. */
typedef double eight __attribute__((vector_size(64), aligned(8), may_alias));
/* Rows whose products are added together. */
#define TOGETHER 8

/* Add to rows of `sums`, `wide` numbers long, the products of `some` columns (count, p) with
   `mixed` (count, wide). */
static void add_products(size_t count, size_t p, const double *some, size_t wide,
                         const double *mixed, double *sums)
{
    size_t row = 0;
    for (; row + 4 <= p; row += 4)
        for (size_t c = 0; c < wide; c += 8)
        {
            eight *to[4], sum[4];
            for (int r = 0; r < 4; r++)
                sum[r] = *(to[r] = (eight *)(sums + (row + (size_t)r) * wide + c));
            for (size_t i = 0; i < count; i++)
            {
                eight one = *(const eight *)(mixed + i * wide + c);
                for (int r = 0; r < 4; r++)
                    sum[r] += some[i * p + row + (size_t)r] * one;
            }
            for (int r = 0; r < 4; r++)
                *to[r] = sum[r];
        }
    for (; row < p; row++)
        for (size_t i = 0; i < count; i++)
            EACH for (size_t c = 0; c < wide; c++)
                sums[row * wide + c] += some[i * p + row] * mixed[i * wide + c];
}

/* With y a row, f what the rows before say of it and u the drift's variance, the whitened row is
   (y - u f) / sqrt(d), and the next row's f is a f + b y. In the sum of the rows' products that of f
   with itself is then one of y with f and y, times what is left of it in all rows to come: only
   numbers that are not zero are multiplied. */
static int products(size_t n, size_t q, size_t p, const double *time, double rate, double power,
                    const double *variance, const int64_t *starts, const int64_t *places,
                    const double *numbers, const double *full, double *room, double *d,
                    double *normal)
{
    size_t k = q + p, wide = WIDE(k), held = 0;
    double *carry = room, *add = carry + n + 1, *rest = add + n, *before = rest + n + 1;
    double *mixed = before + wide, *sums = mixed + TOGETHER * wide, known = 0, weight = 0;
    for (size_t i = 0; i < n; i++)
    {
        double fading = i ? exp(rate * (time[i - 1] - time[i])) : 0;
        known = i ? fading * (known + d[i - 1] * weight * weight) * fading : 0;
        double seen = power * known;
        d[i] = variance[i] + power - seen * power;
        if (!(d[i] > 0))
            return 0;
        if (i)
        {
            carry[i - 1] = fading * (1 - weight * power);
            add[i - 1] = fading * weight;
        }
        weight = (1 - seen) / d[i];
    }
    rest[n] = 0;
    if (n)
        carry[n - 1] = add[n - 1] = 0;
    for (size_t i = n; i-- > 0;)
        rest[i] = power * power / d[i] + carry[i] * carry[i] * rest[i + 1];
    for (size_t c = 0; c < (1 + TOGETHER + k) * wide; c++)
        before[c] = 0;
    for (size_t i = 0; i < n; i++)
    {
        double a = carry[i], b = add[i], left = rest[i + 1];
        double own = 0.5 * (1 / d[i] + left * b * b), other = left * a * b - power / d[i];
        const int64_t *first = places + starts[i], *end = places + starts[i + 1];
        const double *number = numbers + starts[i], *beside = full + i * p;
        double *now = mixed + held * wide;
        EACH for (size_t c = 0; c < wide; c++) now[c] = other * before[c];
        EACH for (size_t c = 0; c < wide; c++) before[c] *= a;
        for (const int64_t *at = first; at < end; at++)
        {
            now[*at] += own * number[at - first];
            before[*at] += b * number[at - first];
        }
        EACH for (size_t c = 0; c < p; c++) now[q + c] += own * beside[c];
        EACH for (size_t c = 0; c < p; c++) before[q + c] += b * beside[c];
        for (const int64_t *at = first; at < end; at++)
        {
            double by = number[at - first], *row = sums + (size_t)*at * wide;
            EACH for (size_t c = 0; c < wide; c++) row[c] += by * now[c];
        }
        if (++held == TOGETHER || i + 1 == n)
        {
            add_products(held, p, full + (i + 1 - held) * p, wide, mixed, sums + q * wide);
            held = 0;
        }
    }
    for (size_t a = 0; a < k; a++)
        for (size_t b = 0; b <= a; b++)
            normal[a * k + b] = normal[b * k + a] = sums[a * wide + b] + sums[b * wide + a];
    return 1;
}

static void elementary(int which, size_t n, const double *y, const double *x, double *out)
{
    double sine, cosine;
    if (which == 0)
        EACH for (size_t i = 0; i < n; i++) sine_and_cosine(x[i], out + i, &cosine);
    else if (which == 1)
        EACH for (size_t i = 0; i < n; i++) sine_and_cosine(x[i], &sine, out + i);
    else if (which == 2)
        EACH for (size_t i = 0; i < n; i++) out[i] = arcsine(x[i]);
    else
        EACH for (size_t i = 0; i < n; i++) out[i] = arctangent(y[i], x[i]);
}

const struct loops LOOPS = {LEVEL, scattered, grid, look_up, gram, whiten, products, elementary};
