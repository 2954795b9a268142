! What a run is asked to do: the namelist groups of the input file, their defaults and their checks.
module input
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use namelist_file, only: group, read_groups
  use text, only: exact, lower, str
  implicit none
  private
  public :: settings, face_control, table_value, read_input, default_run, most_time, name_length
  public :: control_displacement, control_traction, control_free, face_names, axis_names

  character(len=2), parameter :: face_names(6) = ['x-', 'x+', 'y-', 'y+', 'z-', 'z+']
  character(len=1), parameter :: axis_names(3) = ['x', 'y', 'z']
  integer, parameter :: control_displacement = 1, control_traction = 2, control_free = 3
  character(len=12), parameter :: control_names(3) = [character(len=12) :: 'displacement', 'traction', 'free']
  real(dp), parameter :: table_1(9) = [16.0_dp, 4.0_dp, 0.5_dp, 2.0_dp, 1.1_dp, 1.01_dp, &
                                     1.0_dp, 0.0_dp, 0.0_dp]
  integer, parameter :: name_length = 40  ! of a state variable
  real(dp), parameter :: least_time = 1.0e-12_dp, most_time = 1.0e12_dp  ! in any unit: seconds, days, weeks

  ! One direction of one face, controlled over time.
  type :: face_control
    integer :: face = 1                          ! place in face_names
    integer :: direction = 1                     ! place in axis_names
    integer :: control = control_displacement
    real(dp), allocatable :: time(:), value(:)   ! piecewise linear, constant beyond its ends
    integer :: line = 0                          ! in the input file; 0: a default
  end type face_control

  type :: settings
    character(len=:), allocatable :: file        ! the input file's name, for messages
    real(dp), allocatable :: props(:), statev_initial(:)  ! kPa and days; statev_initial has NSTATV entries
    character(len=:), allocatable :: umat_file   ! '': the UMAT this program is linked with
    character(len=80) :: cmname = 'MYOGROWTH'
    character(len=name_length), allocatable :: statev_names(:)  ! none: G, lambda_e ... of ours, SDV1 ... of others
    real(dp) :: size(3) = 1
    real(dp) :: duration = 42, dt = 0.05_dp, dt_min = 0.05e-6_dp, dt_increase = 2
    type(face_control), allocatable :: faces(:)
    real(dp), allocatable :: field_time(:), field_value(:)  ! field variable 1, as a face's table
    logical :: has_field = .false.
    integer :: max_iterations = 15, max_cutbacks = 10
    real(dp) :: tolerance_residual = 1.0e-10_dp, tolerance_displacement = 1.0e-8_dp
    logical :: symmetrise = .false., log_residuals = .true.
    integer :: reaction_face = 2, reaction_direction = 1
    real(dp) :: print_every = 0                  ! 0: duration/20
    character(len=:), allocatable :: folder
    character(len=:), allocatable :: of_element  ! the groups given that say how the element is loaded, '' if none
  end type settings

contains

  ! The run without an input file: the paper's cube, stretched by 10 % along its fibre in one day and held.
  subroutine default_run(s)
    type(settings), intent(out) :: s
    type(face_control) :: pull

    call set_defaults(s, 'default run')
    pull%face = 2
    pull%time = [0.0_dp, 1.0_dp]
    pull%value = [0.0_dp, 0.1_dp]
    s%faces = [s%faces, pull]
  end subroutine default_run

  subroutine read_input(file, s)
    character(len=*), intent(in) :: file
    type(settings), intent(out) :: s
    type(group), allocatable :: groups(:)
    character(len=*), parameter :: known = '&material, &element, &time, &field, &face, &solver, &output'
    logical :: any_face
    integer :: i

    call set_defaults(s, file)
    call read_groups(file, groups)
    any_face = .false.
    do i = 1, size(groups)
      associate (g => groups(i))
        if (index(' element time face solver ', ' '//g%name//' ') > 0 .and. index(s%of_element, '&'//g%name) == 0) then
          s%of_element = s%of_element//' &'//g%name
        end if
        if (g%name /= 'face') call check_once(groups(:i))
        select case (g%name)
        case ('material')
          call read_material(g, s)
        case ('element')
          call read_element(g, s)
        case ('time')
          call read_time(g, s)
        case ('field')
          call g%check_names([character(len=5) :: 'time', 'value'])
          call require(g, g%has('value'), 'value', 'is missing')
          call read_table(g, s%field_time, s%field_value)
          s%has_field = .true.
        case ('face')
          if (.not. any_face) deallocate (s%faces)
          if (.not. any_face) allocate (s%faces(0))
          any_face = .true.
          call read_face(g, s)
        case ('solver')
          call read_solver(g, s)
        case ('output')
          call read_output(g, s)
        case default
          call g%fail_at(g%line, 'unknown group; known: '//known)
        end select
      end associate
    end do
  end subroutine read_input

  subroutine set_defaults(s, file)
    type(settings), intent(inout) :: s
    character(len=*), intent(in) :: file
    integer :: axis

    s%file = file
    s%of_element = ''
    s%props = table_1
    allocate (s%statev_initial(8), source=0.0_dp)
    allocate (s%statev_names(0))
    s%field_time = [0.0_dp]
    s%field_value = [0.0_dp]
    s%umat_file = ''
    s%folder = '.'
    allocate (s%faces(3))
    do axis = 1, 3
      s%faces(axis)%face = 2*axis - 1
      s%faces(axis)%direction = axis
      s%faces(axis)%time = [0.0_dp]
      s%faces(axis)%value = [0.0_dp]
    end do
  end subroutine set_defaults

  subroutine check_once(groups)
    type(group), intent(in) :: groups(:)
    integer :: i, last

    last = size(groups)
    do i = 1, last - 1
      if (groups(i)%name == groups(last)%name) then
        call groups(last)%fail_at(groups(last)%line, 'given already in line '//str(groups(i)%line))
      end if
    end do
  end subroutine check_once

  subroutine read_material(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    real(dp), allocatable :: first(:)
    character(len=:), allocatable :: cmname
    integer, parameter :: most_states = 10000
    integer :: nstatv

    call g%check_names([character(len=14) :: 'props', 'nstatv', 'statev_initial', 'statev_names', 'umat_file', 'cmname'])
    call g%numbers('props', s%props)
    nstatv = size(s%statev_initial)
    call g%whole('nstatv', 0, most_states, nstatv)
    allocate (first(0))
    call g%numbers('statev_initial', first)
    call require(g, size(first) <= nstatv, 'statev_initial', 'has '//str(size(first))// &
                 ' values: there are nstatv = '//str(nstatv)//' state variables')
    deallocate (s%statev_initial)
    allocate (s%statev_initial(nstatv), source=0.0_dp)
    s%statev_initial(:size(first)) = first
    call g%quoted('umat_file', s%umat_file)
    call require(g, s%umat_file /= '' .or. .not. g%has('umat_file'), 'umat_file', 'must not be empty')
    call read_statev_names(g, nstatv, s%statev_names)
    cmname = trim(s%cmname)
    call g%quoted('cmname', cmname)
    call require(g, len(cmname) >= 1 .and. len(cmname) <= len(s%cmname), 'cmname', 'must have 1 to 80 characters')
    s%cmname = cmname
  end subroutine read_material

  ! The names head the columns of history.csv.
  subroutine read_statev_names(g, nstatv, names)
    type(group), intent(in) :: g
    integer, intent(in) :: nstatv
    character(len=name_length), allocatable, intent(inout) :: names(:)
    character(len=*), parameter :: others(9) = [character(len=10) :: 'time', 's11', 's22', 's33', 's12', 's13', 's23', &
                                                'reaction', 'iterations']
    character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz0123456789_().:+-*/[]'
    integer :: i

    call g%texts('statev_names', names)
    call require(g, size(names) <= nstatv, 'statev_names', 'has '//str(size(names))// &
                 ' names: there are nstatv = '//str(nstatv)//' state variables')
    do i = 1, size(names)
      call require(g, names(i) /= '' .and. verify(lower(trim(names(i))), letters) == 0, 'statev_names', 'name '//str(i)// &
                   ' must be 1 to '//str(name_length)//' letters, digits and _ ( ) . : + - * / [ ]')
      call require(g, .not. any(lower(names(i)) == others), 'statev_names', 'name '//str(i)//', '//trim(names(i))// &
                   ', is that of another column of history.csv')
      call require(g, .not. any(names(:i - 1) == names(i)), 'statev_names', 'name '//str(i)//', '//trim(names(i))// &
                   ', is given twice')
    end do
  end subroutine read_statev_names

  subroutine read_element(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    real(dp), allocatable :: edges(:)

    call g%check_names(['size'])
    edges = s%size
    call g%numbers('size', edges)
    call require(g, size(edges) == 3, 'size', 'must be three numbers, found '//str(size(edges)))
    call require(g, all(edges > 0), 'size', 'every edge length must be > 0')
    call require(g, all(edges >= 1.0e-6_dp .and. edges <= 1.0e6_dp), 'size', &
                 'every edge length must be 1e-6 to 1e6')
    s%size = edges
  end subroutine read_element

  subroutine read_time(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s

    call g%check_names([character(len=11) :: 'duration', 'dt', 'dt_min', 'dt_increase'])
    call g%number('duration', s%duration)
    call require_time(g, s%duration, 'duration')
    call g%number('dt', s%dt)
    call require_time(g, s%dt, 'dt')
    call require(g, s%duration/s%dt <= 1.0e7_dp, 'dt', 'must be at least duration/1e7 = '//str(s%duration/1.0e7_dp))
    call g%number('dt_increase', s%dt_increase)
    call require(g, s%dt_increase >= 1 .and. s%dt_increase <= 1000, 'dt_increase', 'must be 1 to 1000')
    s%dt_min = 1.0e-6_dp*s%dt
    call g%number('dt_min', s%dt_min)  ! a shorter one could be below the rounding of time, which then never ends
    call require(g, s%dt_min >= 1.0e-8_dp*s%dt .and. s%dt_min <= s%dt, 'dt_min', &
                 'must be 1e-8 dt to dt, dt = '//str(s%dt))
  end subroutine read_time

  subroutine read_face(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    type(face_control) :: c
    character(len=:), allocatable :: name, direction, control

    call g%check_names([character(len=9) :: 'name', 'direction', 'control', 'time', 'value'])
    c%line = g%line
    name = ''
    call g%quoted('name', name)
    c%face = choice(g, 'name', name, face_names)
    direction = axis_names((c%face + 1)/2)
    call g%quoted('direction', direction)
    c%direction = choice(g, 'direction', direction, axis_names)
    control = trim(control_names(control_displacement))
    call g%quoted('control', control)
    c%control = choice(g, 'control', control, control_names)
    if (c%control == control_free) then
      call require(g, .not. g%has('value'), 'value', "control = 'free' takes no value")
    else if (c%control == control_traction) then
      call require(g, g%has('value'), 'value', "is missing; control = 'traction' needs it")
    end if
    call read_table(g, c%time, c%value)
    s%faces = [s%faces, c]
  end subroutine read_face

  ! A piecewise linear function of time; a single value is constant, none is 0.
  subroutine read_table(g, time, value)
    type(group), intent(in) :: g
    real(dp), allocatable, intent(out) :: time(:), value(:)
    integer :: i

    allocate (time(0), value(0))
    call g%numbers('time', time)
    call g%numbers('value', value)
    if (size(value) == 0 .and. size(time) == 0) value = [0.0_dp]
    if (size(value) == 1 .and. size(time) == 0) time = [0.0_dp]
    call require(g, size(value) == size(time), 'value', 'time has '//str(size(time))// &
                 ' numbers, value has '//str(size(value))//'; they must be as many')
    do i = 1, size(time)
      call require(g, abs(time(i)) <= most_time, 'time', 'every time must be -1e12 to 1e12')
      if (i > 1) call require(g, time(i) > time(i - 1), 'time', 'must increase, but '//exact(time(i - 1))// &
                              ' is followed by '//exact(time(i)))
    end do
  end subroutine read_table

  ! Its value at a time, constant beyond its ends.
  pure function table_value(time, value, at) result(x)
    real(dp), intent(in) :: time(:), value(:), at
    real(dp) :: x, w
    integer :: i

    i = count(time <= at)
    if (i == 0) then
      x = value(1)
    else if (i == size(time)) then
      x = value(i)
    else
      w = (at - time(i))/(time(i + 1) - time(i))
      x = (1 - w)*value(i) + w*value(i + 1)
    end if
  end function table_value

  subroutine read_solver(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s

    call g%check_names([character(len=22) :: 'max_iterations', 'max_cutbacks', 'tolerance_residual', &
                        'tolerance_displacement', 'symmetrise', 'log_residuals'])
    call g%whole('max_iterations', 1, 1000, s%max_iterations)
    call g%whole('max_cutbacks', 0, 1000, s%max_cutbacks)
    call g%number('tolerance_residual', s%tolerance_residual)
    call require(g, s%tolerance_residual > 0 .and. s%tolerance_residual < 1, 'tolerance_residual', &
                 'must be > 0 and < 1')
    call g%number('tolerance_displacement', s%tolerance_displacement)
    call require(g, s%tolerance_displacement > 0 .and. s%tolerance_displacement < 1, 'tolerance_displacement', &
                 'must be > 0 and < 1')
    call g%flag('symmetrise', s%symmetrise)
    call g%flag('log_residuals', s%log_residuals)
  end subroutine read_solver

  subroutine read_output(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    character(len=:), allocatable :: face, direction

    call g%check_names([character(len=18) :: 'reaction_face', 'reaction_direction', 'print_every', 'folder'])
    face = face_names(s%reaction_face)
    call g%quoted('reaction_face', face)
    s%reaction_face = choice(g, 'reaction_face', face, face_names)
    direction = axis_names((s%reaction_face + 1)/2)
    call g%quoted('reaction_direction', direction)
    s%reaction_direction = choice(g, 'reaction_direction', direction, axis_names)
    call g%quoted('folder', s%folder)
    call require(g, s%folder /= '', 'folder', 'must not be empty')
    call g%number('print_every', s%print_every)
    call require(g, s%print_every > 0 .or. .not. g%has('print_every'), 'print_every', 'must be > 0')
  end subroutine read_output

  subroutine require(g, right, name, what)
    type(group), intent(in) :: g
    logical, intent(in) :: right
    character(len=*), intent(in) :: name, what

    if (.not. right) call g%fail(name, what)
  end subroutine require

  subroutine require_time(g, x, name)
    type(group), intent(in) :: g
    real(dp), intent(in) :: x
    character(len=*), intent(in) :: name

    call require(g, x > 0, name, 'must be > 0')
    call require(g, x >= least_time .and. x <= most_time, name, 'must be 1e-12 to 1e12')
  end subroutine require_time

  integer function choice(g, name, word, words)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name, word, words(:)
    character(len=:), allocatable :: list
    integer :: i

    list = ''
    do i = 1, size(words)
      choice = i
      if (word == words(i)) return
      list = list//merge('  ', ', ', i == 1)//"'"//trim(words(i))//"'"
    end do
    choice = 0
    call g%fail(name, 'must be one of '//trim(adjustl(list)))
  end function choice

end module input
