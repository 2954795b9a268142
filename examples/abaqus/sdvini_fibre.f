C     A fibre field from a table: SDVINI gives every element its fibre
C     direction, STATEV(6:8), before the analysis starts.
C
C     The table has the header element,n1,n2,n3 and a row for each
C     element: its label and its fibre direction in the reference
C     configuration, of any length > 0. Blank lines and text after #
C     are ignored. It is fibres.csv in the folder the job was started
C     in, or the file named by the environment variable
C     MYOGROWTH_FIBRES. An element that is not in it keeps zeros, for
C     which the UMAT takes the direction in PROPS(7:9).
C
C     Abaqus may call SDVINI from several threads at a time. The table
C     is therefore read once, by UEXTERNALDB at the start of the
C     analysis, and not changed after that. The interfaces are written
C     out and not taken from ABA_PARAM.INC, so that any compiler
C     accepts this file; Abaqus/Standard is in double precision.

      MODULE MYOGROWTH_FIBRES
      IMPLICIT NONE
      PRIVATE
      PUBLIC :: READ_TABLE, FAIL, N0
C     N0(:,e) of element e, zero where the table has no such element
      DOUBLE PRECISION, ALLOCATABLE, PROTECTED :: N0(:,:)

      CONTAINS

C     Ends the analysis with a message; % is special to Abaqus.
      SUBROUTINE FAIL(TEXT)
      CHARACTER(LEN=*), INTENT(IN) :: TEXT
      CHARACTER(LEN=500) :: LINE
      CHARACTER(LEN=8) :: NO_CHAR(1)
      INTEGER :: NO_INT(1), I
      DOUBLE PRECISION :: NO_REAL(1)
      EXTERNAL STDB_ABQERR, XIT
      LINE = 'myogrowth SDVINI: '//TEXT
      DO I = 1, LEN(LINE)
        IF (LINE(I:I) .EQ. '%') LINE(I:I) = '?'
      END DO
      NO_CHAR = ' '
      NO_INT = 0
      NO_REAL = 0
      CALL STDB_ABQERR(-3, TRIM(LINE), NO_INT, NO_REAL, NO_CHAR)
      CALL XIT
      END SUBROUTINE FAIL

      SUBROUTINE READ_TABLE
      CHARACTER(LEN=1024) :: PATH
      CHARACTER(LEN=256) :: FOLDER
      CHARACTER(LEN=400) :: FAULT
      INTEGER :: LENGTH, UNIT, STATUS, LARGEST
      EXTERNAL GETOUTDIR
      CALL GET_ENVIRONMENT_VARIABLE('MYOGROWTH_FIBRES', PATH,
     1                              STATUS=STATUS)
      IF (STATUS .EQ. -1) THEN
        CALL FAIL('MYOGROWTH_FIBRES names a file by more than 1024 '
     1            //'characters')
        RETURN
      END IF
      IF (PATH .EQ. ' ') THEN
        CALL GETOUTDIR(FOLDER, LENGTH)
        PATH = FOLDER(:LENGTH)//'/fibres.csv'
      END IF
      OPEN (NEWUNIT=UNIT, FILE=TRIM(PATH), STATUS='OLD',
     1      ACTION='READ', IOSTAT=STATUS)
      IF (STATUS .NE. 0) THEN
        CALL FAIL(TRIM(PATH)//': cannot be opened')
        RETURN
      END IF
C     Twice: for the largest label, then for the directions
      IF (ALLOCATED(N0)) DEALLOCATE (N0)
      LARGEST = 0
      CALL PASS(UNIT, LARGEST, FAULT)
      IF (FAULT .EQ. ' ' .AND. LARGEST .EQ. 0)
     1  FAULT = ': expected the header element,n1,n2,n3 and rows'
      IF (FAULT .EQ. ' ') THEN
        ALLOCATE (N0(3,LARGEST), STAT=STATUS)
        IF (STATUS .NE. 0) THEN
          WRITE (FAULT, '(A,I0)') ': no memory for element labels up '
     1          //'to ', LARGEST
        ELSE
          N0 = 0
          REWIND (UNIT)
          CALL PASS(UNIT, LARGEST, FAULT)
        END IF
      END IF
      CLOSE (UNIT)
      IF (FAULT .NE. ' ') THEN
        IF (ALLOCATED(N0)) DEALLOCATE (N0)
        CALL FAIL(TRIM(PATH)//FAULT)
      END IF
      END SUBROUTINE READ_TABLE

C     Goes through the rows: finds the largest label, and fills N0 if
C     there is one. FAULT names the line and what was expected.
      SUBROUTINE PASS(UNIT, LARGEST, FAULT)
      INTEGER, INTENT(IN) :: UNIT
      INTEGER, INTENT(INOUT) :: LARGEST
      CHARACTER(LEN=*), INTENT(OUT) :: FAULT
      CHARACTER(LEN=400) :: LINE
C     The byte-order mark of UTF-8, which spreadsheets write
      CHARACTER(LEN=3), PARAMETER :: MARK =
     1  CHAR(239)//CHAR(187)//CHAR(191)
      CHARACTER(LEN=12) :: NUMBER
      INTEGER :: STATUS, COUNT, ELEMENT, CUT
      DOUBLE PRECISION :: N(3)
      LOGICAL :: HEADED
      HEADED = .FALSE.
      COUNT = 0
      FAULT = ' '
      DO
        READ (UNIT, '(A)', IOSTAT=STATUS) LINE
        IF (IS_IOSTAT_END(STATUS)) RETURN
        COUNT = COUNT + 1
        IF (STATUS .NE. 0) THEN
          FAULT = ': cannot be read'
          RETURN
        END IF
        IF (COUNT .EQ. 1 .AND. LINE(:3) .EQ. MARK) LINE(:3) = ' '
        CUT = INDEX(LINE, '#')
        IF (CUT .GT. 0) LINE(CUT:) = ' '
        CALL BLANKS(LINE)
        IF (LINE .EQ. ' ') CYCLE
        IF (.NOT. HEADED) THEN
          IF (LINE .NE. 'element,n1,n2,n3')
     1      FAULT = 'the header element,n1,n2,n3'
          HEADED = .TRUE.
        ELSE IF (.NOT. IS_ROW(LINE)) THEN
          FAULT = 'element,n1,n2,n3: a label > 0 and three numbers'
        ELSE
          READ (LINE, *, IOSTAT=STATUS) ELEMENT, N
          IF (STATUS .NE. 0) THEN
            FAULT = 'element,n1,n2,n3: a label > 0 and three numbers'
          ELSE IF (ELEMENT .LE. 0) THEN
            FAULT = 'an element label > 0'
          ELSE IF (.NOT. ALL(ABS(N) .LE. HUGE(N))) THEN
            FAULT = 'finite numbers'
          ELSE IF (ALL(N .EQ. 0)) THEN
            FAULT = 'a direction, of any length > 0'
          ELSE IF (.NOT. ALLOCATED(N0)) THEN
            LARGEST = MAX(LARGEST, ELEMENT)
          ELSE IF (ANY(N0(:,ELEMENT) .NE. 0)) THEN
            FAULT = 'every element once'
          ELSE
            N0(:,ELEMENT) = N
          END IF
        END IF
        IF (FAULT .NE. ' ') THEN
          WRITE (NUMBER, '(I0)') COUNT
          FAULT = ':'//TRIM(NUMBER)//': '//LINE(:MIN(60,LEN_TRIM(LINE)))
     1            //': expected '//FAULT
          RETURN
        END IF
      END DO
      END SUBROUTINE PASS

C     Removes blanks, tabs, DOS line ends and trailing empty columns.
      SUBROUTINE BLANKS(LINE)
      CHARACTER(LEN=*), INTENT(INOUT) :: LINE
      INTEGER :: I, J
      J = 0
      DO I = 1, LEN(LINE)
        IF (LINE(I:I) .EQ. ' ' .OR. IACHAR(LINE(I:I)) .LT. 32) CYCLE
        J = J + 1
        LINE(J:J) = LINE(I:I)
      END DO
      LINE(J+1:) = ' '
C     The empty columns that spreadsheets add
      DO WHILE (J .GT. 0)
        IF (LINE(J:J) .NE. ',') EXIT
        IF (COMMAS(LINE(:J)) .LE. 3 .AND. VERIFY(LINE(:J), ',') .NE. 0)
     1    EXIT
        LINE(J:J) = ' '
        J = J - 1
      END DO
      END SUBROUTINE BLANKS

      INTEGER FUNCTION COMMAS(LINE)
      CHARACTER(LEN=*), INTENT(IN) :: LINE
      INTEGER :: I
      COMMAS = 0
      DO I = 1, LEN(LINE)
        IF (LINE(I:I) .EQ. ',') COMMAS = COMMAS + 1
      END DO
      END FUNCTION COMMAS

C     Whether a line has four fields that consist of the characters of
C     numbers: READ itself would also accept 2*1., / and empty fields.
      LOGICAL FUNCTION IS_ROW(LINE)
      CHARACTER(LEN=*), INTENT(IN) :: LINE
      CHARACTER(LEN=*), PARAMETER :: DIGITS = '0123456789'
      INTEGER :: I, L
      L = LEN_TRIM(LINE)
      I = INDEX(LINE, ',')
      IS_ROW = COMMAS(LINE) .EQ. 3 .AND. INDEX(LINE(:L), ',,') .EQ. 0
     1  .AND. I .GT. 1 .AND. LINE(L:L) .NE. ','
     2  .AND. VERIFY(LINE(:L), DIGITS//'+-.eE,') .EQ. 0
      IF (IS_ROW) IS_ROW = VERIFY(LINE(:I-1), DIGITS) .EQ. 0
C     To READ, 1-2 is 1e-2.
      DO I = 2, L
        IF (SCAN(LINE(I:I), '+-') .GT. 0)
     1    IS_ROW = IS_ROW .AND. SCAN(LINE(I-1:I-1), ',eE') .GT. 0
      END DO
      END FUNCTION IS_ROW

      END MODULE MYOGROWTH_FIBRES


C     Called by Abaqus at the start of the analysis (LOP = 0) and of a
C     restart (LOP = 4), among others.
      SUBROUTINE UEXTERNALDB(LOP, LRESTART, TIME, DTIME, KSTEP, KINC)
      USE MYOGROWTH_FIBRES, ONLY : READ_TABLE
      IMPLICIT NONE
      INTEGER LOP, LRESTART, KSTEP, KINC
      DOUBLE PRECISION TIME(2), DTIME
      IF (LOP .EQ. 0 .OR. LOP .EQ. 4) CALL READ_TABLE
      END SUBROUTINE UEXTERNALDB


C     Called by Abaqus for every material point of a deck that has
C     *INITIAL CONDITIONS, TYPE=SOLUTION, USER.
      SUBROUTINE SDVINI(STATEV, COORDS, NSTATV, NCRDS, NOEL, NPT,
     1                  LAYER, KSPT)
      USE MYOGROWTH_FIBRES, ONLY : FAIL, N0
      IMPLICIT NONE
      INTEGER NSTATV, NCRDS, NOEL, NPT, LAYER, KSPT
      DOUBLE PRECISION STATEV(NSTATV), COORDS(NCRDS)
C     G = 0 is taken as 1 by the UMAT: nothing has grown yet.
      STATEV = 0
      IF (NSTATV .LT. 8) THEN
        CALL FAIL('*DEPVAR must be 8 at least, to hold the fibre')
      ELSE IF (.NOT. ALLOCATED(N0)) THEN
        CALL FAIL('the fibres have not been read: UEXTERNALDB was not '
     1            //'called, or there are two of them')
      ELSE IF (NOEL .GE. 1 .AND. NOEL .LE. SIZE(N0, 2)) THEN
        STATEV(6:8) = N0(:,NOEL)
      END IF
      END SUBROUTINE SDVINI
