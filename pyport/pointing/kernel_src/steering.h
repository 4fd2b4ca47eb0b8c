/* The steering table of the RT32: its numbers as they were computed, its text as it was printed. */

#ifndef PYPORT_KERNEL_STEERING_H
#define PYPORT_KERNEL_STEERING_H

#include <stddef.h>

struct altitude;

/* Offsets on a grid, zenith distances together, or at n pairs of them; the refraction stands
   beside the zenith distances. */
void steering_offsets(const double *p_deg, size_t n, const double *az_deg, size_t m,
                      const double *zd_deg, const double *lift_deg, int paired,
                      struct altitude *room, double *d_az_deg, double *d_zd_deg);
/* Bytes of room that m zenith distances need. */
size_t steering_room(size_t m);
/* The refraction of the table's program. */
void steering_refraction(size_t n, const double *zd_deg, double *lift_deg);
/* The rows of n azimuths and m zenith distances, given as text, with offsets of `width` (12 at
   least) characters; 0 where one does not fit. */
int steering_rows(size_t n, const char *az, size_t az_width, size_t m, const char *zd,
                  size_t zd_width, size_t width, const double *d_az_deg, const double *d_zd_deg,
                  char *out);

#endif
