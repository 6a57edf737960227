# Writes TARGET: for each file of LIST a line of C++, {"its name without folder and ending", "its text"}.
file(READ ${LIST} files)
set(rows "")
foreach(file IN LISTS files)
  cmake_path(GET file STEM name)
  file(READ ${file} text)
  string(APPEND rows "{\"${name}\", R\"~~(${text})~~\"},\n")
endforeach()
file(WRITE ${TARGET} "${rows}")
