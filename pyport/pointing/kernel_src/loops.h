/* The kernel's loops, compiled once for each instruction set. */

#ifndef PYPORT_KERNEL_LOOPS_H
#define PYPORT_KERNEL_LOOPS_H

#include <stddef.h>
#include <stdint.h>

/* Parameters of a form, as pyport.pointing.kernel makes them. */
enum parameter {
    TOWARD, LEAN, LEAN_SQUARED, LEAN_SHARE, UPRIGHT, SOUTH,
    AZ_BY_SINE, AZ_BY_COSINE, AZ_ZERO, ALT_BY_SINE, ALT_BY_COSINE, ALT_ZERO,
    SAG, SAG_SINE, JUMP,
    SIGMA, BETA, ACROSS_BY_SINE, ACROSS_ZERO, RISE_ZERO, RISE_BY_COSINE, RISE_BY_SINE,
    PARAMETERS
};

struct table {
    const double *offsets;      /* both at each node, side by side; rows of azimuth */
    ptrdiff_t rows, row;        /* how many rows, and nodes in one */
    double first_az, last_az, first_zd, last_zd;
};

struct loops {
    const char *name;
    /* Offsets at n points; how many angles are too large to be reduced here. */
    size_t (*scattered)(int exact, const double *p, size_t n, const double *az,
                        const double *alt, double *d_az, double *d_alt);
    /* Offsets at every azimuth for every altitude, azimuths together in memory; as above. */
    size_t (*grid)(int exact, const double *p, size_t columns, const double *az, size_t rows,
                   const double *alt, double *room, double *d_az, double *d_alt);
    /* Offsets between a table's nodes; how many places lie beyond it. */
    size_t (*look_up)(const struct table *t, size_t n, const double *az, const double *zd,
                      double *d_az, double *d_zd);
    /* Products of k columns of n rows, each row so heavy, and of the columns with a target. */
    void (*gram)(size_t k, size_t n, const double *columns, const double *weight,
                 const double *target, double *normal, double *right);
    /* The middle one of n numbers, or the mean of the two; `room` holds as many. */
    double (*median)(size_t n, const double *values, double *room);
    /* Whiten some n rows of k columns, written in their place, under scatter and drifts of so many terms: d is the variance of a
       row given those before it, `room` holds DRIFT_ROOM(n, terms) numbers; 0 where a d is none. */
    int (*whiten)(size_t n, const int64_t *rows, size_t terms, size_t k, const double *time,
                  const double *rate, const double *power, const double *variance, const double *columns, double *room,
                  double *d, double *white);
    /* The products of q + p columns of n rows under scatter and drifts of so many terms. Of the
       first q only the numbers that are not zero are given, row by row, of the others all: (n, p).
       `room` holds PRODUCTS_ROOM(n, q, p, terms) numbers; 0 where a d is none. */
    int (*products)(size_t n, size_t q, size_t p, size_t terms, const double *time,
                    const double *rate, const double *power, const double *variance,
                    const int64_t *starts, const int64_t *places, const double *numbers,
                    const double *full, double *room, double *d, double *normal);
    /* A function of n numbers: 0 sine, 1 cosine, 2 arcsine of x; 3 arctangent of y and x. */
    void (*elementary)(int which, size_t n, const double *y, const double *x, double *out);
};

/* Arrays that a grid's azimuths need. */
#define COLUMN_ROOMS 5
/* Numbers that whitening needs. */
#define DRIFT_ROOM(n, terms) ((terms) * ((terms) + 2 * (n) + 128))
#define WIDE(k) (((k) + 7) / 8 * 8)
#define PRODUCTS_ROOM(n, q, p, terms) \
    ((terms) * (2 * (terms) + 1 + 3 * (n) + WIDE(p) + WIDE(q)) + (n) * (1 + WIDE(p)) \
     + WIDE(p) * WIDE(p) + (q) * (1 + WIDE(p) + WIDE(q)) + 16 * WIDE(q) + 1)

#endif
