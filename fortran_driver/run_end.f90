! The end of the program: by us, with a status, or by a UMAT (STOP, XIT, EXIT), which must not pass for success.
module run_end
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: dp => real64, error_unit
  implicit none
  private
  public :: end_run, watch_end, expect_end, time_reached

  real(dp) :: time_reached = 0  ! the rows of history.csv end here
  logical :: expected = .false.

  interface
    function c_atexit(handler) bind(c, name='atexit') result(status)
      import :: c_funptr, c_int
      type(c_funptr), value :: handler
      integer(c_int) :: status
    end function c_atexit
    function c_fflush(stream) bind(c, name='fflush') result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_fflush
    subroutine c_exit_now(status) bind(c, name='_exit')
      import :: c_int
      integer(c_int), value :: status
    end subroutine c_exit_now
  end interface

contains

  subroutine end_run(status)
    integer, intent(in) :: status

    expected = .true.
    stop status, quiet=.true.
  end subroutine end_run

  ! From here on only end_run, or expect_end before the program's last statement, is a proper end.
  subroutine watch_end()
    expected = .false.
    if (c_atexit(c_funloc(at_exit)) /= 0) error stop 'myogrowth_driver: atexit failed'
  end subroutine watch_end

  subroutine expect_end()
    expected = .true.
  end subroutine expect_end

  subroutine at_exit() bind(c, name='myogrowth_driver_at_exit')
    if (expected) return
    write (error_unit, '(a, es12.5, a)') 'the UMAT ended the run, after time', time_reached, &
      '. history.csv has the rows up to there.'
    flush (error_unit)
    if (c_fflush(c_null_ptr) /= 0) continue
    call c_exit_now(2_c_int)
  end subroutine at_exit

end module run_end
