! The published routine in plain Fortran loops: over a grid and over scattered points.
! A build that promotes REAL*4 promotes these too. Parameters are in degrees, angles in radians.

subroutine grid(n, m, az, alt, p, daz, dalt)
   integer :: n, m, i, j
   real*4 :: az(n), alt(m), p(12), daz(m, n), dalt(m, n)
   do i = 1, n
      do j = 1, m
         call Model(az(i), alt(j), daz(j, i), dalt(j, i), p)
      end do
   end do
end subroutine grid

subroutine scattered(n, az, alt, p, daz, dalt)
   integer :: n, i
   real*4 :: az(n), alt(n), p(12), daz(n), dalt(n)
   do i = 1, n
      call Model(az(i), alt(i), daz(i), dalt(i), p)
   end do
end subroutine scattered

subroutine scattered_approximate(n, az, alt, p, daz, dalt)
   integer :: n, i
   real*4 :: az(n), alt(n), p(12), daz(n), dalt(n)
   do i = 1, n
      call ModelA(az(i), alt(i), daz(i), dalt(i), p)
   end do
end subroutine scattered_approximate
