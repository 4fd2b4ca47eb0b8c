! table_tool FILE: print a binary steering table as the ASCII one.
! table_tool FILE -: read azimuth and zenith distance, a pair a line, and print their offsets.
program table_tool
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use steering_offsets, only: offsets_at
  use steering_table, only: read_table, table_type
  implicit none
  type(table_type) :: table
  character(512) :: path
  character(64) :: error
  real(real64) :: az, zd, d_az, d_zd
  logical :: inside
  integer :: i, j, status

  call get_command_argument(1, path)
  call read_table(trim(path), table, error)
  if (error /= '') then
    write (error_unit, '(4a)') 'table_tool: error: ', trim(path), ': ', trim(error)
    stop 2, quiet=.true.
  end if
  if (command_argument_count() == 1) then
    do i = 1, table%n_az
      do j = 1, table%n_zd
        write (*, '(i4,i3,2f12.7)') nint(table%az_first + (i - 1)*table%az_step), &
          nint(table%zd_first + (j - 1)*table%zd_step), table%d_az(j, i)/1d7, table%d_zd(j, i)/1d7
      end do
    end do
  else
    do
      read (*, *, iostat=status) az, zd
      if (status /= 0) exit
      call offsets_at(table, az, zd, d_az, d_zd, inside)
      if (.not. inside) stop 2
      write (*, '(2f12.7)') d_az, d_zd
    end do
  end if
end program
