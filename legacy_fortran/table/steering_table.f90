! Reads pyport's binary steering table on a little-endian machine; docs/steering-table.md.
module steering_table
  use, intrinsic :: iso_fortran_env, only: int8, int32, int64, real64
  implicit none
  type table_type
    integer(int32) :: n_az = 0, n_zd = 0
    real(real64) :: az_first, az_step, zd_first, zd_step, unit_deg
    character(64) :: model, refraction
    integer(int32), allocatable :: d_az(:, :), d_zd(:, :) ! (zenith distance, azimuth)
  end type
contains
  ! Fills `table`; `error` is blank, or says why nothing was read.
  subroutine read_table(path, table, error)
    character(*), intent(in) :: path
    type(table_type), intent(out) :: table
    character(*), intent(out) :: error
    integer(int8), allocatable :: bytes(:)
    integer(int32) :: head(4), crc
    character(8) :: magic
    integer :: unit, length, status
    error = 'cannot be opened'
    open (newunit=unit, file=path, access='stream', status='old', action='read', iostat=status)
    if (status /= 0) return
    inquire (unit, size=length)
    reading: block
      error = 'is no binary steering table'
      if (length < 516) exit reading
      read (unit) magic, head
      if (magic /= 'PYPORTST') exit reading
      error = 'has another layout version than 1'
      if (head(1) /= 1) exit reading
      error = 'has not the length that its header promises'
      if (head(2) /= 512 .or. any(head(3:4) < 1)) exit reading
      if (length /= 516 + 8*int(head(3), int64)*head(4)) exit reading
      allocate (bytes(length - 4))
      read (unit, pos=1) bytes, crc
      error = 'is damaged: its checksum does not fit its content'
      if (crc32(bytes) /= crc) exit reading
      error = ''
      allocate (table%d_az(head(4), head(3)), table%d_zd(head(4), head(3)))
      read (unit, pos=17) table%n_az, table%n_zd, table%az_first, table%az_step, &
        table%zd_first, table%zd_step, table%unit_deg, table%model, table%refraction
      read (unit, pos=513) table%d_az, table%d_zd
    end block reading
    close (unit)
  end subroutine
  pure integer(int32) function crc32(bytes) result(crc) ! as zlib computes it
    integer(int8), intent(in) :: bytes(:)
    integer :: i, bit
    crc = -1
    do i = 1, size(bytes)
      crc = ieor(crc, iand(int(bytes(i), int32), 255))
      do bit = 1, 8
        crc = merge(ieor(ishft(crc, -1), -306674912), ishft(crc, -1), btest(crc, 0)) ! EDB88320
      end do
    end do
    crc = not(crc)
  end function
end module
