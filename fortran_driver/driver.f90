! myogrowth_driver: one finite element, or one material point, around an Abaqus UMAT.
program driver
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use files, only: absolute, start_output, say
  use input, only: settings, name_length, read_input, default_run
  use material_point, only: material, increment, external_call, analysis_begins, analysis_ends
  use output, only: report, open_report
  use prescribed_path, only: path, read_path, run_path
  use replay, only: run_replay
  use run_end, only: expect_end, time_reached, watch_end
  use solver, only: run_element
  use text, only: str, visible, note, stop_run, status_input, status_output
  use umat_interface, only: umat, load_umat
  implicit none
  save  ! or the leak checker takes for lost what the program still holds at its end

  character(len=*), parameter :: name = 'myogrowth_driver'
  integer, parameter :: message_unit = 7
  character(len=*), parameter :: options = '--out FOLDER, --umat FILE, --path FILE, --replay FILE, --quiet, --help'
  character(len=:), allocatable :: input_file, folder, umat_file, path_file, replay_file
  type(settings) :: s
  type(material) :: m
  type(report) :: r
  type(path) :: p
  character(len=:), allocatable :: inputs(:)
  logical :: quiet, wants_help

  call read_command_line()
  if (wants_help) then
    call print_help()
    stop
  end if
  call start_output(quiet)
  if (input_file == '') then
    call default_run(s)
  else
    call read_input(input_file, s)
  end if
  if (folder /= '') s%folder = folder
  if (umat_file /= '') s%umat_file = umat_file
  if (s%print_every <= 0) s%print_every = s%duration/20
  call set_material()
  allocate (character(len=max(len(input_file), len(path_file))) :: inputs(2))
  inputs = [character(len=len(inputs)) :: input_file, path_file]
  if (replay_file /= '') then
    call run_replay(replay_file, m%library%umat)
    call expect_end()
    stop
  end if
  if (path_file == '') then
    call open_report(s%folder, inputs, states(), quiet, s%log_residuals, .false., s%print_every, r)
  else
    if (s%of_element /= '') call note(s%file//':'//s%of_element//': not used with --path, which leads one point')
    p = read_path(path_file)
    call open_report(s%folder, inputs, states(), quiet, .false., .true., 0.0_dp, r)  ! every row is printed
  end if
  if (.not. m%library%is_ours) call open_message_file()
  call external_call(m, analysis_begins, 0.0_dp, increment(number=0))
  if (path_file == '') then
    call run_element(s, m, r)
  else
    call run_path(p, m, r)
  end if
  call external_call(m, analysis_ends, time_reached, increment(number=0))
  call r%close()
  if (.not. m%library%is_ours) call close_message_file()
  call expect_end()

contains

  subroutine read_command_line()
    character(len=:), allocatable :: argument
    integer :: i

    input_file = ''
    folder = ''
    umat_file = ''
    path_file = ''
    replay_file = ''
    quiet = .false.
    wants_help = .false.
    i = 1
    do while (i <= command_argument_count())
      argument = argument_at(i)
      select case (argument)
      case ('--help', '-h')
        wants_help = .true.
        return
      case ('--quiet')
        quiet = .true.
      case ('--out')
        call take_value(i, folder)
      case ('--umat')
        call take_value(i, umat_file)
      case ('--path')
        call take_value(i, path_file)
      case ('--replay')
        call take_value(i, replay_file)
      case default
        if (index(argument, '-') == 1) then
          call stop_run(status_input, name//': unknown option '//visible(argument)//'; known: '//options)
        else if (argument == '') then
          call stop_run(status_input, name//': an argument is empty; expected INPUT.nml or an option: '//options)
        else if (input_file /= '') then
          call stop_run(status_input, name//': one input file, found "'//input_file//'" and "'//argument//'"')
        end if
        input_file = argument
      end select
      i = i + 1
    end do
    if (replay_file /= '' .and. (input_file /= '' .or. path_file /= '')) then
      call stop_run(status_input, name//': --replay goes without INPUT.nml and --path')
    else if (replay_file /= '' .and. quiet) then
      call stop_run(status_input, name//': --replay goes without --quiet: it only prints')
    end if
  end subroutine read_command_line

  function argument_at(i) result(argument)
    integer, intent(in) :: i
    character(len=:), allocatable :: argument
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(len=length) :: argument)
    call get_command_argument(i, argument)
  end function argument_at

  ! The value of the option at i, which moves on to it.
  subroutine take_value(i, value)
    integer, intent(inout) :: i
    character(len=:), allocatable, intent(inout) :: value
    character(len=:), allocatable :: option

    option = argument_at(i)
    if (value /= '') call stop_run(status_input, name//': '//option//' is given twice')
    i = i + 1
    if (i <= command_argument_count()) value = argument_at(i)
    if (value == '') call stop_run(status_input, name//': '//option//' needs a value')
    if (index(value, '--') == 1) then
      call stop_run(status_input, name//': '//option//' needs a value, found the option '//visible(value))
    end if
  end subroutine take_value

  subroutine set_material()
    character(len=:), allocatable :: message

    m%props = s%props
    m%statev_initial = s%statev_initial
    m%cmname = s%cmname
    m%field_time = s%field_time
    m%field_value = s%field_value
    m%library%umat => umat
    call watch_end()
    call check_field()
    if (s%umat_file == '') return
    call load_umat(s%umat_file, absolute(s%folder), case_name(), m%library, message)
    if (.not. associated(m%library%umat)) then
      call stop_run(status_input, name//': the UMAT '//s%umat_file//' cannot be used: '//message)
    end if
    if (input_file == '' .and. replay_file == '' .and. .not. m%library%is_ours) then
      call note('no INPUT.nml: '//s%umat_file//' is given the '//str(size(s%props))//' PROPS of myogrowth''s default '// &
                'run, and '//str(size(s%statev_initial))//' STATEV')
    end if
    if (m%library%not_called /= '') call note(s%umat_file//': has, and this driver does not call,'//m%library%not_called)
  end subroutine set_material

  ! What myogrowth's UMAT reads from a field variable has to be said, and what it does not read is noted.
  subroutine check_field()
    logical :: is_read

    if (s%umat_file /= '') return
    is_read = .false.
    if (size(s%props) >= 20) is_read = .not. (s%props(20) > -1 .or. s%props(20) < -1)
    if (s%has_field .and. .not. is_read) then
      call note(s%file//': &field: not used: it is the activation with props(20) = -1 only')
    end if
    if (s%has_field .or. .not. is_read) return
    call stop_run(status_input, s%file//': &material: props(20) = -1: the activation is field variable 1, whose values over '// &
                  'time, &field, are missing')
  end subroutine check_field

  ! The columns of history.csv for STATEV: ours are five and have names.
  function states() result(names)
    character(len=name_length), allocatable :: names(:)
    integer :: i

    if (m%library%is_ours .and. size(s%statev_names) == 0) then
      names = [character(len=name_length) :: 'G', 'lambda_e', 'lambda', 'J', 'Je']
      return
    end if
    allocate (names(size(m%statev_initial)))
    names(:size(s%statev_names)) = s%statev_names
    do i = size(s%statev_names) + 1, size(names)
      names(i) = 'SDV'//str(i)
    end do
  end function states

  ! For GETJOBNAME: the input file's name without folder and ending.
  function case_name() result(case)
    character(len=:), allocatable :: case

    case = input_file(index(input_file, '/', back=.true.) + 1:)
    if (index(case, '.', back=.true.) > 1) case = case(:index(case, '.', back=.true.) - 1)
    if (case == '') case = 'default'
  end function case_name

  ! Abaqus has its message file open on unit 7, and UMATs write to it.
  subroutine open_message_file()
    integer :: status
    character(len=200) :: reason

    open (unit=message_unit, file=s%folder//'/umat.msg', status='replace', action='write', iostat=status, iomsg=reason)
    if (status /= 0) call stop_run(status_output, s%folder//'/umat.msg: cannot be written: '//trim(reason))
  end subroutine open_message_file

  subroutine close_message_file()
    integer :: written

    flush (message_unit)
    inquire (unit=message_unit, size=written)
    close (message_unit, status=merge('delete', 'keep  ', written == 0))
  end subroutine close_message_file

  subroutine print_help()
    character(len=*), parameter :: text(22) = [character(len=100) :: &
      'usage: myogrowth_driver [INPUT.nml] [options]', &
      '', &
      'Leads one 8-node brick through the loading in INPUT.nml, as an implicit finite-element code would:', &
      'Newton''s method in finite strain, with automatic cut-backs. Without INPUT.nml: a cube of muscle,', &
      'stretched by 10 % along its fibre in one day and held to day 42 (kPa, days).', &
      '', &
      '  --out FOLDER   where to write history.csv and newton.log; made if it is missing (default .)', &
      '  --umat FILE    a shared library with a UMAT (umat_, umat, UMAT or UMAT_) to use instead of', &
      '                 myogrowth''s; ./run umat makes one from a source file', &
      '  --path FILE    no element: one UMAT call per row of FILE, a CSV file with the header', &
      '                 time,F11,F12,F13,F21,F22,F23,F31,F32,F33; also writes ddsdde.csv', &
      '  --replay FILE  no element: the one UMAT call in FILE again, and what comes back. myogrowth''s', &
      '                 UMAT writes such files into the folder that the environment variable', &
      '                 MYOGROWTH_DUMP names, one for each call that gave no result', &
      '  --quiet        nothing on the screen but errors', &
      '  --help         this text', &
      '', &
      'Optional groups in INPUT.nml: &material, &element, &time, &field, &face (several), &solver, &output;', &
      'the files in fortran_driver/cases explain them.', &
      '', &
      'Exit status: 0 done, 1 something in the input is wrong, 2 the run could not be finished,', &
      '3 a result could not be written.']
    integer :: i

    call start_output(.false.)
    do i = 1, size(text)
      call say(trim(text(i)))
    end do
  end subroutine print_help

end program driver
