! The published routines called once for each of n points: what f2py wraps, one call for many points.
! Nothing is computed here. A build that promotes REAL*4 promotes these arrays too.

subroutine models(n, az, alt, p, daz, dalt)
   integer :: n, i
   real*4 :: az(n), alt(n), p(12, n), daz(n), dalt(n)
   do i = 1, n
      call Model(az(i), alt(i), daz(i), dalt(i), p(1, i))
   end do
end subroutine models

subroutine modelas(n, az, alt, p, daz, dalt)
   integer :: n, i
   real*4 :: az(n), alt(n), p(12, n), daz(n), dalt(n)
   do i = 1, n
      call ModelA(az(i), alt(i), daz(i), dalt(i), p(1, i))
   end do
end subroutine modelas

subroutine hjumps(n, az, alt, jump)
   integer :: n, i
   real*4 :: az(n), alt(n), jump(n), Hjump
   external Hjump
   do i = 1, n
      jump(i) = Hjump(az(i), alt(i))
   end do
end subroutine hjumps
