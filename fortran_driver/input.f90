! What a run is asked to do: the namelist groups of the input file, their defaults and their checks.
module input
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use namelist_file, only: group, read_groups
  use text, only: str
  implicit none
  private
  public :: settings, face_control, read_input, default_run
  public :: control_displacement, control_traction, control_free, face_names, axis_names

  character(len=2), parameter :: face_names(6) = ['x-', 'x+', 'y-', 'y+', 'z-', 'z+']
  character(len=1), parameter :: axis_names(3) = ['x', 'y', 'z']
  integer, parameter :: control_displacement = 1, control_traction = 2, control_free = 3
  character(len=12), parameter :: control_names(3) = [character(len=12) :: 'displacement', 'traction', 'free']
  real(dp), parameter :: table_1(9) = [16.0_dp, 4.0_dp, 0.5_dp, 2.0_dp, 1.1_dp, 1.01_dp, &
                                     1.0_dp, 0.0_dp, 0.0_dp]
  real(dp), parameter :: unset = -huge(1.0_dp)  ! marks what the file does not give
  integer, parameter :: text_length = 1024

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
    real(dp) :: size(3) = 1
    real(dp) :: duration = 42, dt = 0.05_dp, dt_min = unset, dt_increase = 2
    type(face_control), allocatable :: faces(:)
    integer :: max_iterations = 15, max_cutbacks = 10
    real(dp) :: tolerance_residual = 1.0e-10_dp, tolerance_displacement = 1.0e-8_dp
    logical :: symmetrise = .false., log_residuals = .true.
    integer :: reaction_face = 2, reaction_direction = 1
    real(dp) :: print_every = unset
    character(len=:), allocatable :: folder
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
    logical :: any_face
    integer :: i

    call set_defaults(s, file)
    call read_groups(file, groups)
    any_face = .false.
    do i = 1, size(groups)
      associate (g => groups(i))
        if (g%name /= 'face') call check_once(groups(:i))
        select case (g%name)
        case ('material')
          call read_material(g, s)
        case ('element')
          call read_element(g, s)
        case ('time')
          call read_time(g, s)
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
          call g%fail_at(g%line, 'unknown group; known: &material, &element, &time, &face, &solver, &output')
        end select
      end associate
    end do
    call derive(s)
  end subroutine read_input

  subroutine set_defaults(s, file)
    type(settings), intent(inout) :: s
    character(len=*), intent(in) :: file
    integer :: axis

    s%file = file
    s%props = table_1
    allocate (s%statev_initial(8), source=0.0_dp)
    s%umat_file = ''
    s%folder = '.'
    allocate (s%faces(3))
    do axis = 1, 3
      s%faces(axis)%face = 2*axis - 1
      s%faces(axis)%direction = axis
      s%faces(axis)%time = [0.0_dp]
      s%faces(axis)%value = [0.0_dp]
    end do
    call derive(s)
  end subroutine set_defaults

  ! Defaults that depend on other values.
  subroutine derive(s)
    type(settings), intent(inout) :: s

    if (s%dt_min <= unset) s%dt_min = 1.0e-6_dp*s%dt
    if (s%print_every <= unset) s%print_every = s%duration/20
  end subroutine derive

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
    real(dp) :: props(1000), statev_initial(1000)
    integer :: nstatv
    character(len=text_length) :: umat_file
    real(dp), allocatable :: first(:)
    namelist /material/ props, nstatv, statev_initial, umat_file
    character(len=*), parameter :: known(4) = [character(len=60) :: 'props: at most 1000 numbers', &
      'nstatv: one whole number', 'statev_initial: at most 1000 numbers', 'umat_file: one text in quotes']
    character(len=:), allocatable :: record
    integer :: i, status

    props = unset
    nstatv = size(s%statev_initial)
    statev_initial = unset
    umat_file = ''
    do i = 1, size(g%item)
      record = g%record(i, known)
      read (record, nml=material, iostat=status)
      call g%check_read(i, status, known)
    end do
    if (any(props > unset)) call given(g, 'props', props, s%props)
    call require(g, nstatv >= 0 .and. nstatv <= size(statev_initial), 'nstatv', 'must be 0 to 1000')
    call given(g, 'statev_initial', statev_initial, first)
    call require(g, size(first) <= nstatv, 'statev_initial', 'has '//str(size(first))// &
                 ' values: there are nstatv = '//str(nstatv)//' state variables')
    deallocate (s%statev_initial)
    allocate (s%statev_initial(nstatv), source=0.0_dp)
    s%statev_initial(:size(first)) = first
    s%umat_file = trim(umat_file)
  end subroutine read_material

  subroutine read_element(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    real(dp) :: size(3)
    real(dp), allocatable :: edges(:)
    namelist /element/ size
    character(len=*), parameter :: known(1) = ['size: three numbers']
    character(len=:), allocatable :: record
    integer :: i, status

    if (ubound(g%item, 1) == 0) return
    size = unset
    do i = 1, ubound(g%item, 1)
      record = g%record(i, known)
      read (record, nml=element, iostat=status)
      call g%check_read(i, status, known)
    end do
    call given(g, 'size', size, edges)
    call require(g, ubound(edges, 1) == 3, 'size', 'must be three numbers')
    call require(g, all(edges > 0), 'size', 'every edge length must be > 0')
    s%size = edges
  end subroutine read_element

  subroutine read_time(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    real(dp) :: duration, dt, dt_min, dt_increase
    namelist /time/ duration, dt, dt_min, dt_increase
    character(len=*), parameter :: known(4) = [character(len=30) :: 'duration: one number', &
      'dt: one number', 'dt_min: one number', 'dt_increase: one number']
    character(len=:), allocatable :: record
    integer :: i, status

    duration = s%duration
    dt = s%dt
    dt_min = unset
    dt_increase = s%dt_increase
    do i = 1, size(g%item)
      record = g%record(i, known)
      read (record, nml=time, iostat=status)
      call g%check_read(i, status, known)
    end do
    call require_positive(g, duration, 'duration')
    call require_positive(g, dt, 'dt')
    call require(g, duration/dt <= 1.0e7_dp, 'dt', 'must be at least duration/1e7 = '//str(duration/1.0e7_dp))
    if (.not. dt_min <= unset) then
      call require(g, dt_min > 0 .and. dt_min <= dt, 'dt_min', 'must be > 0 and at most dt')
    end if
    call require_positive(g, dt_increase, 'dt_increase')
    call require(g, dt_increase >= 1, 'dt_increase', 'must be >= 1')
    s%duration = duration
    s%dt = dt
    s%dt_min = dt_min
    s%dt_increase = dt_increase
  end subroutine read_time

  subroutine read_face(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    character(len=text_length) :: name, direction, control
    real(dp) :: time(1000), value(1000)
    namelist /face/ name, direction, control, time, value
    character(len=*), parameter :: known(5) = [character(len=40) :: 'name: one text in quotes', &
      'direction: one text in quotes', 'control: one text in quotes', 'time: at most 1000 numbers', &
      'value: at most 1000 numbers']
    type(face_control) :: c
    character(len=:), allocatable :: record
    integer :: i, status

    name = ''
    direction = ''
    control = control_names(control_displacement)
    time = unset
    value = unset
    do i = 1, size(g%item)
      record = g%record(i, known)
      read (record, nml=face, iostat=status)
      call g%check_read(i, status, known)
    end do
    c%line = g%line
    c%face = choice(g, 'name', name, face_names)
    c%direction = (c%face + 1)/2
    if (direction /= '') c%direction = choice(g, 'direction', direction, axis_names)
    c%control = choice(g, 'control', control, control_names)
    call given(g, 'time', time, c%time)
    call given(g, 'value', value, c%value)

    if (c%control == control_free) then
      call require(g, size(c%value) == 0, 'value', "control = 'free' takes no value")
    else if (c%control == control_traction) then
      call require(g, size(c%value) > 0, 'value', "is missing; control = 'traction' needs it")
    end if
    if (size(c%value) == 0 .and. size(c%time) == 0) c%value = [0.0_dp]
    if (size(c%value) == 1 .and. size(c%time) == 0) c%time = [0.0_dp]
    call require(g, size(c%value) == size(c%time), 'value', 'time has '//str(size(c%time))// &
                 ' numbers, value has '//str(size(c%value))//'; they must be as many')
    do i = 2, size(c%time)
      call require(g, c%time(i) > c%time(i - 1), 'time', 'must increase, but '//str(c%time(i - 1))// &
                   ' is followed by '//str(c%time(i)))
    end do
    s%faces = [s%faces, c]
  end subroutine read_face

  subroutine read_solver(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    integer :: max_iterations, max_cutbacks
    real(dp) :: tolerance_residual, tolerance_displacement
    logical :: symmetrise, log_residuals
    namelist /solver/ max_iterations, max_cutbacks, tolerance_residual, tolerance_displacement, symmetrise, &
      log_residuals
    character(len=*), parameter :: known(6) = [character(len=40) :: 'max_iterations: one whole number', &
      'max_cutbacks: one whole number', 'tolerance_residual: one number', &
      'tolerance_displacement: one number', 'symmetrise: .true. or .false.', &
      'log_residuals: .true. or .false.']
    character(len=:), allocatable :: record
    integer :: i, status

    max_iterations = s%max_iterations
    max_cutbacks = s%max_cutbacks
    tolerance_residual = s%tolerance_residual
    tolerance_displacement = s%tolerance_displacement
    symmetrise = s%symmetrise
    log_residuals = s%log_residuals
    do i = 1, size(g%item)
      record = g%record(i, known)
      read (record, nml=solver, iostat=status)
      call g%check_read(i, status, known)
    end do
    call require(g, max_iterations >= 1, 'max_iterations', 'must be >= 1')
    call require(g, max_cutbacks >= 0, 'max_cutbacks', 'must be >= 0')
    call require(g, tolerance_residual > 0 .and. tolerance_residual < 1, 'tolerance_residual', &
                 'must be > 0 and < 1')
    call require(g, tolerance_displacement > 0 .and. tolerance_displacement < 1, 'tolerance_displacement', &
                 'must be > 0 and < 1')
    s%max_iterations = max_iterations
    s%max_cutbacks = max_cutbacks
    s%tolerance_residual = tolerance_residual
    s%tolerance_displacement = tolerance_displacement
    s%symmetrise = symmetrise
    s%log_residuals = log_residuals
  end subroutine read_solver

  subroutine read_output(g, s)
    type(group), intent(in) :: g
    type(settings), intent(inout) :: s
    character(len=text_length) :: reaction_face, reaction_direction, folder
    real(dp) :: print_every
    namelist /output/ reaction_face, reaction_direction, print_every, folder
    character(len=*), parameter :: known(4) = [character(len=40) :: 'reaction_face: one text in quotes', &
      'reaction_direction: one text in quotes', 'print_every: one number', 'folder: one text in quotes']
    character(len=:), allocatable :: record
    integer :: i, status

    reaction_face = face_names(s%reaction_face)
    reaction_direction = ''
    print_every = unset
    folder = s%folder
    do i = 1, size(g%item)
      record = g%record(i, known)
      read (record, nml=output, iostat=status)
      call g%check_read(i, status, known)
    end do
    s%reaction_face = choice(g, 'reaction_face', reaction_face, face_names)
    s%reaction_direction = (s%reaction_face + 1)/2
    if (reaction_direction /= '') then
      s%reaction_direction = choice(g, 'reaction_direction', reaction_direction, axis_names)
    end if
    if (.not. print_every <= unset) then
      call require_positive(g, print_every, 'print_every')
      s%print_every = print_every
    end if
    call require(g, folder /= '', 'folder', 'must not be empty')
    s%folder = trim(folder)
  end subroutine read_output

  subroutine require(g, right, name, what)
    type(group), intent(in) :: g
    logical, intent(in) :: right
    character(len=*), intent(in) :: name, what

    if (.not. right) call g%fail(name, what)
  end subroutine require

  subroutine require_positive(g, x, name)
    type(group), intent(in) :: g
    real(dp), intent(in) :: x
    character(len=*), intent(in) :: name

    call require(g, x > 0, name, 'must be > 0')
    call require(g, x <= huge(x), name, 'must be finite')
  end subroutine require_positive

  ! The values that the file gives of an array which was all unset.
  subroutine given(g, name, values, list)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name
    real(dp), intent(in) :: values(:)
    real(dp), allocatable, intent(out) :: list(:)
    integer :: i, n

    n = size(values)
    do while (n > 0)
      if (.not. values(n) <= unset) exit
      n = n - 1
    end do
    do i = 1, n
      call require(g, abs(values(i)) < huge(1.0_dp), name, 'value '//str(i)//' is missing or not finite')
    end do
    allocate (list(n), source=values(:n))
  end subroutine given

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
