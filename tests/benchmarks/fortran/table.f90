! A steering table written the way a Fortran program would: the published routine at every point of
! the grid, a refraction, one formatted row a point. The file's name is the first argument.

program table
   implicit none
   real*4, parameter :: degree = 3.14159265 / 180
   real*4 :: p(12), az, alt, daz, dalt, refraction, first, h, fold
   integer :: i, j
   character(200) :: name
   p = (/ -0.049282183, -0.059631502, 0.009452264, -0.013254868, 0.001393287, -0.000304149, &
          0.031273499, 0.011457918, -0.011750501, 0.004538503, 0.004290860, -0.020392426 /)
   call get_command_argument(1, name)
   open(unit=1, file=trim(name), status='replace')
   do i = -270, 270
      fold = i
      if (i > 180) fold = i - 360
      if (i < -180) fold = i + 360
      do j = -5, 89
         az = fold * degree
         alt = (90 - j) * degree
         call Model(az, alt, daz, dalt, p)
         h = 90 - abs(j)
         first = 1 / tan((h + 7.31 / (h + 4.4)) / 57.29)
         h = h + first / 60
         refraction = 1 / tan((h + 7.31 / (h + 4.4)) / 57.29)
         refraction = (refraction - 0.06 * sin((14.7 * first + 13) / 57.29)) / 60
         write(1, '(I4,I3,2F12.7)') i, j, daz, -dalt - sign(refraction, real(j))
      end do
   end do
   close(1)
end program table
