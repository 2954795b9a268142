! From controlled faces to prescribed displacements and forces at the nodes.
module boundary
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use element, only: brick, corner, n_nodes, n_dofs
  use lapack, only: dsyev
  use input, only: settings, face_control, table_value, control_displacement, control_traction, face_names, axis_names
  use text, only: str, stop_run, status_input
  implicit none
  private
  public :: boundary_conditions, new_boundary, on_face

  type :: boundary_conditions
    type(face_control), allocatable :: control(:)
    real(dp), allocatable :: field_time(:)  ! knots of the field variable
    integer :: source(n_dofs) = 0   ! the control that prescribes a degree of freedom, 0 if it is free
    real(dp) :: face_area(3) = 0    ! of the faces across x, y, z
  contains
    procedure :: displacements, forces, next_knot
  end type boundary_conditions

contains

  ! Ends the run if two controls contradict each other or rigid motions are left.
  subroutine new_boundary(s, b, bc)
    type(settings), intent(in) :: s
    type(brick), intent(in) :: b
    type(boundary_conditions), intent(out) :: bc
    integer :: i, node, dof

    bc%control = s%faces
    bc%field_time = s%field_time
    bc%face_area = product(b%size)/b%size
    do i = 1, size(bc%control)
      associate (c => bc%control(i))
        call check_unique(s%file, bc%control(:i))
        if (c%control /= control_displacement) cycle
        do node = 1, n_nodes
          if (.not. on_face(node, c%face)) cycle
          dof = 3*(node - 1) + c%direction
          if (bc%source(dof) == 0) then
            bc%source(dof) = i
          else if (.not. same_table(c, bc%control(bc%source(dof)))) then
            call contradiction(s%file, c, bc%control(bc%source(dof)), 'on the nodes that both faces share')
          end if
        end do
      end associate
    end do
    call check_rigid_motion(s%file, bc)
  end subroutine new_boundary

  pure logical function on_face(node, face)
    integer, intent(in) :: node, face

    on_face = (corner((face + 1)/2, node) > 0) .eqv. modulo(face, 2) == 0
  end function on_face

  ! Prescribed displacements at a time; 0 where the node is free.
  function displacements(bc, time) result(u)
    class(boundary_conditions), intent(in) :: bc
    real(dp), intent(in) :: time
    real(dp) :: u(n_dofs)
    integer :: dof

    u = 0
    do dof = 1, n_dofs
      if (bc%source(dof) > 0) u(dof) = value_of(bc%control(bc%source(dof)), time)
    end do
  end function displacements

  ! Nodal forces of the tractions: dead, per reference area, so a quarter of the face's force at each corner.
  function forces(bc, time) result(f)
    class(boundary_conditions), intent(in) :: bc
    real(dp), intent(in) :: time
    real(dp) :: f(n_dofs)
    integer :: i, node, dof

    f = 0
    do i = 1, size(bc%control)
      associate (c => bc%control(i))
        if (c%control /= control_traction) cycle
        do node = 1, n_nodes
          if (.not. on_face(node, c%face)) cycle
          dof = 3*(node - 1) + c%direction
          f(dof) = f(dof) + value_of(c, time)*bc%face_area((c%face + 1)/2)/4
        end do
      end associate
    end do
  end function forces

  ! The first knot of any table after a time; huge if there is none.
  function next_knot(bc, time) result(knot)
    class(boundary_conditions), intent(in) :: bc
    real(dp), intent(in) :: time
    real(dp) :: knot
    integer :: i

    knot = minval(bc%field_time, mask=bc%field_time > time)  ! huge if there is none
    do i = 1, size(bc%control)
      associate (t => bc%control(i)%time)
        knot = min(knot, minval(t, mask=t > time))
      end associate
    end do
  end function next_knot

  pure real(dp) function value_of(c, time)
    type(face_control), intent(in) :: c
    real(dp), intent(in) :: time

    value_of = table_value(c%time, c%value, time)
  end function value_of

  ! Whether two tables are the same function: piecewise linear ones are if they agree at all knots.
  logical function same_table(a, b)
    type(face_control), intent(in) :: a, b
    integer :: i

    same_table = .true.
    do i = 1, size(a%time)
      same_table = same_table .and. equal(a%value(i), value_of(b, a%time(i)))
    end do
    do i = 1, size(b%time)
      same_table = same_table .and. equal(b%value(i), value_of(a, b%time(i)))
    end do
  end function same_table

  elemental logical function equal(x, y)
    real(dp), intent(in) :: x, y

    equal = abs(x - y) <= 4*epsilon(x)*max(abs(x), abs(y))
  end function equal

  ! The last of the controls must not control, in another way, what an earlier one does.
  subroutine check_unique(file, controls)
    character(len=*), intent(in) :: file
    type(face_control), intent(in) :: controls(:)
    integer :: i

    associate (c => controls(size(controls)))
      do i = 1, size(controls) - 1
        if (controls(i)%face /= c%face .or. controls(i)%direction /= c%direction) cycle
        if (controls(i)%control == control_displacement .and. c%control == control_displacement) cycle
        call contradiction(file, c, controls(i), 'on the same face')
      end do
    end associate
  end subroutine check_unique

  subroutine contradiction(file, a, b, place)
    character(len=*), intent(in) :: file, place
    type(face_control), intent(in) :: a, b

    call stop_run(status_input, file//':'//str(a%line)//": &face: name = '"//face_names(a%face)// &
                  "', direction = '"//axis_names(a%direction)//"': contradicts line "//str(b%line)// &
                  ", name = '"//face_names(b%face)//"', direction = '"//axis_names(b%direction)//"', "//place)
  end subroutine contradiction

  ! A rigid motion is left if a combination of the six moves no prescribed degree of freedom. Whether there is one
  ! does not depend on the edge lengths, so a cube serves for bricks of any shape.
  subroutine check_rigid_motion(file, bc)
    character(len=*), intent(in) :: file
    type(boundary_conditions), intent(in) :: bc
    character(len=*), parameter :: motion(6) = [character(len=19) :: &
      'translation along x', 'translation along y', 'translation along z', &
      'rotation about x', 'rotation about y', 'rotation about z']
    real(dp), parameter :: negligible = 1.0e-8_dp
    real(dp) :: modes(n_dofs, 6), gram(6, 6), eigenvalue(6), work(64), X(3)
    character(len=:), allocatable :: left
    integer :: node, axis, n, m, info, i

    modes = 0
    do node = 1, n_nodes
      X = corner(:, node)
      do axis = 1, 3
        n = modulo(axis, 3) + 1
        m = modulo(n, 3) + 1
        modes(3*(node - 1) + axis, axis) = 1
        modes(3*(node - 1) + m, 3 + axis) = X(n)
        modes(3*(node - 1) + n, 3 + axis) = -X(m)
      end do
    end do
    do i = 1, 6
      where (bc%source == 0) modes(:, i) = 0
    end do
    gram = matmul(transpose(modes), modes)
    call dsyev('V', 'U', 6, gram, 6, eigenvalue, work, size(work), info)
    n = count(eigenvalue <= negligible*max(eigenvalue(6), 1.0_dp))
    if (n == 0) return
    left = ''
    do i = 1, 6
      if (sum(gram(i, :n)**2) > 0.01_dp) left = left//', '//trim(motion(i))
    end do
    call stop_run(status_input, file//': the model can move as a rigid body: '//left(3:)// &
                  "; hold it by &face groups with control = 'displacement'")
  end subroutine check_rigid_motion

end module boundary
