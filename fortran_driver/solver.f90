! Newton's method on one element, and the increments of time with their cut-backs.
module solver
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use boundary, only: boundary_conditions, new_boundary, on_face
  use element, only: brick, new_brick, assemble, n_nodes, n_points, n_dofs
  use input, only: settings
  use material_point, only: material, point, increment, new_point, external_call, increment_begins, increment_ends
  use output, only: report
  use text, only: str, stop_run, status_input, status_run
  implicit none
  private
  public :: run_element

  ! Everything that an abandoned increment must leave as it was.
  type :: solution
    real(dp) :: time = 0
    real(dp) :: u(n_dofs) = 0   ! displacements
    real(dp) :: f(n_dofs) = 0   ! internal forces
    type(point) :: points(n_points)
  end type solution

  interface
    subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: dp
      integer, intent(in) :: n, nrhs, lda, ldb
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgesv
  end interface

contains

  ! A row of the history at every multiple of dt and at the end; increments also end at the tables' knots.
  subroutine run_element(s, m, r)
    type(settings), intent(in) :: s
    type(material), intent(in) :: m
    type(report), intent(inout) :: r
    real(dp), parameter :: same = 1.0e-8_dp      ! times closer than this, in dt, are one
    real(dp), parameter :: remainder = 1.0e-3_dp ! a shorter rest, in increments, is not left over
    type(brick) :: b
    type(boundary_conditions) :: bc
    type(solution) :: now, trial
    character(len=:), allocatable :: reason
    real(dp) :: step, grid, target, factor
    integer :: p, i, n_grid, iterations, row_iterations, cutbacks, increments, all_cutbacks, all_iterations

    b = new_brick(s%size, s%symmetrise)
    call new_boundary(s, b, bc)
    do p = 1, n_points
      now%points(p) = new_point(m, p, matmul(b%X, b%N(:, p)))
    end do
    trial = now
    if (m%library%is_ours) then
      call write_initial(b, m, now, s, r)
    else  ! Abaqus makes no call without time, and others' UMATs may divide by it
      call r%row(0.0_dp, now%points, 0.0_dp, 0, last=.false.)
    end if

    increments = 0
    all_cutbacks = 0
    all_iterations = 0
    cutbacks = 0
    step = s%dt
    n_grid = max(1, ceiling(s%duration/s%dt - same))
    do i = 1, n_grid
      grid = i*s%dt
      if (i == n_grid) grid = s%duration
      row_iterations = 0
      do
        target = min(grid, bc%next_knot(now%time + same*s%dt))
        trial%time = now%time + step
        if (trial%time > target - remainder*step) trial%time = target
        call newton(s, b, bc, m, increments + 1, r, now, trial, iterations, factor, reason)
        all_iterations = all_iterations + iterations
        if (factor < 1) then
          step = factor*(trial%time - now%time)
          cutbacks = cutbacks + 1
          if (cutbacks > s%max_cutbacks) call give_up('more than max_cutbacks = '//str(s%max_cutbacks))
          if (step < s%dt_min) call give_up('dt = '//str(step)//' would be below dt_min = '//str(s%dt_min))
          call r%tell('  cut-back at time '//str(now%time)//' to dt = '//str(step)//': '//reason)
          all_cutbacks = all_cutbacks + 1
          cycle
        end if
        call external_call(m, increment_ends, trial%time, increment(now%time, trial%time - now%time, increments + 1))
        now = trial
        cutbacks = 0
        increments = increments + 1
        row_iterations = row_iterations + iterations
        step = min(s%dt, step*s%dt_increase)
        if (now%time >= grid - same*s%dt) exit
      end do
      call r%row(now%time, now%points, reaction(s, now%f), row_iterations, last=i == n_grid)
    end do
    call r%tell(str(increments)//' increments, '//str(all_cutbacks)//' cut-backs, '//str(all_iterations)// &
               ' iterations')
  contains
    subroutine give_up(limit)
      character(len=*), intent(in) :: limit

      call stop_run(status_run, s%file//': stopped at time '//str(now%time)//' of '//str(s%duration)// &
                    ': '//reason//'; '//limit//'. history.csv has the rows up to there.')
    end subroutine give_up
  end subroutine run_element

  ! The undeformed element, by a call without time. The state is not kept: as in any host, the first
  ! increment starts from STATEV as given.
  subroutine write_initial(b, m, start, s, r)
    type(brick), intent(in) :: b
    type(material), intent(in) :: m
    type(solution), intent(in) :: start
    type(settings), intent(in) :: s
    type(report), intent(inout) :: r
    type(point) :: points(n_points)
    real(dp) :: f(n_dofs), K(n_dofs, n_dofs), pnewdt
    character(len=:), allocatable :: reason

    points = start%points
    call assemble(b, m, start%points, increment(0.0_dp, 0.0_dp, 1), start%u, points, f, K, pnewdt, reason)
    if (pnewdt < 1) then
      call stop_run(status_input, s%file//': PROPS or STATEV cannot be used: at F = 1 and without time, '//reason)
    end if
    call r%row(0.0_dp, points, reaction(s, f), 0, last=.false.)
  end subroutine write_initial

  ! Full Newton from `now` to trial%time; the prescribed displacements are reached by the first, linear step.
  ! factor < 1: abandoned for `reason`, to be tried again with a time increment that is so much shorter.
  subroutine newton(s, b, bc, m, number, r, now, trial, iterations, factor, reason)
    type(settings), intent(in) :: s
    type(brick), intent(in) :: b
    type(boundary_conditions), intent(in) :: bc
    type(material), intent(in) :: m
    integer, intent(in) :: number
    type(report), intent(in) :: r
    type(solution), intent(in) :: now
    type(solution), intent(inout) :: trial
    integer, intent(out) :: iterations
    real(dp), intent(out) :: factor
    character(len=:), allocatable, intent(inout) :: reason
    real(dp), parameter :: halve = 0.5_dp, least = 0.1_dp  ! range of the factor
    real(dp), parameter :: strain_scale = 1.0e-4_dp  ! gives forces a scale where none act
    type(increment) :: inc
    real(dp) :: K(n_dofs, n_dofs), force(n_dofs), prescribed(n_dofs), du(n_dofs), residual, correction, scale
    integer :: info

    inc = increment(now%time, trial%time - now%time, number)
    call external_call(m, increment_begins, inc%time, inc)
    force = bc%forces(trial%time)
    prescribed = bc%displacements(trial%time)
    trial%u = now%u
    factor = halve
    correction = 0
    iterations = 0
    do
      call assemble(b, m, now%points, inc, trial%u, trial%points, trial%f, K, factor, reason)
      if (factor < 1) then
        factor = max(least, min(halve, factor))
        return
      end if
      scale = max(norm2(trial%f), norm2(force), strain_scale*maxval(abs(K))*minval(b%size))
      residual = norm2(pack(force - trial%f, bc%source == 0))/scale
      call r%iteration(number, trial%time, inc%dtime, iterations, residual, correction)
      if (.not. (ieee_is_finite(residual) .and. all(ieee_is_finite(K)))) then
        reason = 'the residual or the tangent is not a number'
        exit
      else if (iterations > 0 .and. residual <= s%tolerance_residual &
               .and. correction <= s%tolerance_displacement) then
        factor = 1
        return
      else if (iterations == s%max_iterations) then
        reason = 'no convergence in max_iterations = '//str(iterations)//', residual '//str(residual)
        exit
      end if
      call solve(K, force - trial%f, prescribed - trial%u, bc%source > 0, du, info)
      if (info /= 0) then
        reason = 'the tangent is singular'
        exit
      end if
      trial%u = merge(prescribed, trial%u + du, bc%source > 0)
      correction = maxval(abs(du), mask=bc%source == 0)/maxval(b%size)
      correction = max(correction, 0.0_dp)  ! maxval of nothing is -huge
      iterations = iterations + 1
    end do
    factor = halve
  end subroutine newton

  ! K du = r with some of du known: their columns go to the right-hand side, their rows are dropped.
  subroutine solve(K, r, known, fixed, du, info)
    real(dp), intent(in) :: K(n_dofs, n_dofs), r(n_dofs), known(n_dofs)
    logical, intent(in) :: fixed(n_dofs)
    real(dp), intent(out) :: du(n_dofs)
    integer, intent(out) :: info
    real(dp) :: a(n_dofs, n_dofs), right(n_dofs, 1)
    integer :: dof(n_dofs), n, i, pivot(n_dofs)

    n = count(.not. fixed)
    dof(:n) = pack([(i, i=1, n_dofs)], .not. fixed)
    du = merge(known, 0.0_dp, fixed)
    info = 0
    if (n == 0) return
    a(:n, :n) = K(dof(:n), dof(:n))
    right(:n, 1) = r(dof(:n)) - matmul(K(dof(:n), :), du)
    call dgesv(n, 1, a, n_dofs, pivot, right, n_dofs, info)
    du(dof(:n)) = right(:n, 1)
  end subroutine solve

  ! The force on a face: outward if its direction is the face's normal, else along the axis.
  function reaction(s, f) result(total)
    type(settings), intent(in) :: s
    real(dp), intent(in) :: f(n_dofs)
    real(dp) :: total
    integer :: node

    total = 0
    do node = 1, n_nodes
      if (on_face(node, s%reaction_face)) total = total + f(3*(node - 1) + s%reaction_direction)
    end do
    if (s%reaction_face == 2*s%reaction_direction - 1) total = 0 - total
  end function reaction

end module solver
