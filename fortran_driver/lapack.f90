! What the driver and the library of Abaqus's utilities call of LAPACK.
module lapack
  use, intrinsic :: iso_fortran_env, only: dp => real64
  implicit none
  private
  public :: dsyev

  ! Eigenvalues in ascending order and, with JOBZ = V, eigenvectors in the columns of A, of a symmetric matrix.
  interface
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: dp
      character(len=1), intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface
end module lapack
