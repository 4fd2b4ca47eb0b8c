! Offsets interpolated in an ASCII table, as a steering program would: read all of it, then answer.
! It prints how long reading the table and interpolating take, the targets' own file apart.
! Arguments: the table, a file of azimuths and zenith distances (REAL*8, unformatted stream), and
! a file for the answers.

program lookup
   implicit none
   integer, parameter :: n = 541, m = 95
   real*8 :: of(2, m, n), u, v, w(4)
   real*8, allocatable :: at(:, :), out(:, :)
   integer :: i, j, k, count, iaz, izd
   integer*8 :: start, read_by, begin, end, rate
   character(200) :: name
   call system_clock(start, rate)
   call get_command_argument(1, name)
   open(unit=1, file=trim(name), status='old')
   do i = 1, n
      do j = 1, m
         read(1, '(I4,I3,2F12.7)') iaz, izd, of(1, j, i), of(2, j, i)
      end do
   end do
   close(1)
   call system_clock(read_by)
   call get_command_argument(2, name)
   open(unit=2, file=trim(name), status='old', access='stream', form='unformatted')
   read(2) count
   allocate(at(2, count), out(2, count))
   read(2) at
   close(2)
   call system_clock(begin)
   do k = 1, count
      u = at(1, k) + 270
      v = at(2, k) + 5
      i = min(int(u), n - 2)
      j = min(int(v), m - 2)
      u = u - i
      v = v - j
      w = (/ (1 - u) * (1 - v), (1 - u) * v, u * (1 - v), u * v /)
      out(:, k) = w(1) * of(:, j + 1, i + 1) + w(2) * of(:, j + 2, i + 1) &
                + w(3) * of(:, j + 1, i + 2) + w(4) * of(:, j + 2, i + 2)
   end do
   call system_clock(end)
   print *, real(read_by - start + end - begin, 8) / rate, 's to read the table and to interpolate'
   call get_command_argument(3, name)
   open(unit=3, file=trim(name), status='replace', access='stream', form='unformatted')
   write(3) out
   close(3)
end program lookup
