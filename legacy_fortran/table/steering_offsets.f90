! Offsets at any azimuth and zenith distance, for a steering program written in Fortran.
module steering_offsets
  use, intrinsic :: iso_fortran_env, only: real64
  use steering_table, only: table_type
  implicit none
  private
  public :: offsets_at

contains

  ! Interpolates linearly in azimuth and zenith distance, all in degrees; `inside` is false,
  ! and the offsets are zero, where the table does not reach.
  pure subroutine offsets_at(table, az, zd, d_az, d_zd, inside)
    type(table_type), intent(in) :: table
    real(real64), intent(in) :: az, zd
    real(real64), intent(out) :: d_az, d_zd
    logical, intent(out) :: inside
    real(real64) :: u, v, weight(2, 2)
    integer :: i, j

    u = (az - table%az_first)/table%az_step
    v = (zd - table%zd_first)/table%zd_step
    d_az = 0
    d_zd = 0
    inside = u >= 0 .and. u <= table%n_az - 1 .and. v >= 0 .and. v <= table%n_zd - 1
    if (.not. inside) return
    i = min(int(u), table%n_az - 2)
    j = min(int(v), table%n_zd - 2)
    u = u - i
    v = v - j
    weight = reshape([(1 - v)*(1 - u), v*(1 - u), (1 - v)*u, v*u], [2, 2])
    d_az = sum(weight*table%d_az(j + 1:j + 2, i + 1:i + 2))*table%unit_deg
    d_zd = sum(weight*table%d_zd(j + 1:j + 2, i + 1:i + 2))*table%unit_deg
  end subroutine
end module
